/* The ways of a bound function: what it takes, which arrays it makes, and what it returns. There are seven:

    pose      f(q, out=None)                entry(*leading, q, out) -> bool; an array of the shape ``numbers``
    truth     f(q)                          entry(*leading, q) -> int; False or True for the two codes in ``numbers``
    number    f(q)                          entry(*leading, q[None], record) -> bool; the number that the record begins with
    edge      f(q_a, q_b, resolution)       entry(*leading, q_a[None], q_b[None], resolution, status, free) -> bool; whether it touches,
                                            for the two codes in ``numbers``, how far it is free, and q there
    copy      f(T)                          entry(*leading, T, out) -> bool; an array of the shape ``numbers``, which T has too
    search    f(target, seed)               entry(*leading, target, seed, q, info) -> bool; q and info, an array of one record,
                                            or None if there is no solution
    branches  f(target)                     entry(*leading, target, q, truths) -> int; q, both rows of truths, and the code; or None if
                                            the code proves nothing. ``numbers``: of branches, and of codes that prove something
*/
#include "bound.h"

#include <string.h>

/* ---- arrays and their slots ---- */

static int is_numbers(PyObject *object, int dimensions, int writable) {
    if (!PyArray_CheckExact(object)) return 0;
    PyArrayObject *array = (PyArrayObject *)object;
    return PyArray_NDIM(array) == dimensions && PyArray_TYPE(array) == NPY_DOUBLE &&
           (writable ? PyArray_ISCARRAY(array) : PyArray_ISCARRAY_RO(array));
}

static int is_vector(PyObject *object, npy_intp n) {
    return is_numbers(object, 1, 0) && PyArray_DIM((PyArrayObject *)object, 0) == n;
}

static int is_matrix(PyObject *object, npy_intp rows, npy_intp columns, int writable) {
    return is_numbers(object, 2, writable) && PyArray_DIM((PyArrayObject *)object, 0) == rows &&
           PyArray_DIM((PyArrayObject *)object, 1) == columns;
}

static int64_t *put_vector(int64_t *slots, const void *data, npy_intp n) {
    slots[0] = (int64_t)(intptr_t)data;
    slots[1] = n;
    return slots + 2;
}

static int64_t *put_matrix(int64_t *slots, const void *data, npy_intp rows, npy_intp columns) {
    slots[0] = (int64_t)(intptr_t)data;
    slots[1] = rows;
    slots[2] = columns;
    return slots + 3;
}

static void *data_of(PyObject *array) { return PyArray_DATA((PyArrayObject *)array); }

static PyObject *new_array_of(int type, int dimensions, npy_intp rows, npy_intp columns) {
    npy_intp shape[2] = {rows, columns};
    PyArray_Descr *elements = PyArray_DescrFromType(type);
    return PyArray_NewFromDescr(&PyArray_Type, elements, dimensions, shape, NULL, NULL, 0, NULL); /* SimpleNew asks for more first */
}

static PyObject *new_record_like(PyObject *array) {
    npy_intp shape[1] = {1};
    PyArray_Descr *elements = PyArray_DESCR((PyArrayObject *)array);
    Py_INCREF((PyObject *)elements);
    return PyArray_NewFromDescr(&PyArray_Type, elements, 1, shape, NULL, NULL, 0, NULL);
}

static PyObject *new_array(int dimensions, npy_intp rows, npy_intp columns) {
    return new_array_of(NPY_DOUBLE, dimensions, rows, columns);
}

/* The slots of a call: those that are bound, and room for the rest, which ``bind`` has counted. Where the machine code keeps the
   interpreter's lock they are the bound function's own, otherwise a copy, since another thread may call it at the same time. */
static int64_t *slots_of(Bound *bound, int64_t *copy) {
    if (!bound->entry->releases_lock) return bound->slots;
    return memcpy(copy, bound->slots, bound->n_slots * sizeof *copy);
}

/* The same of a scene: a copy, with other rows of the table of objects unless ``span`` is NULL. */
static int64_t *slots_of_scene(Bound *bound, int64_t *copy, const int64_t *span) {
    memcpy(copy, bound->slots, bound->n_slots * sizeof *copy);
    if (span) memcpy(copy + bound->n_slots - SPAN_TO_END, span, sizeof(Span));
    return copy;
}

/* ---- the seven ways ---- */

PyObject *pose_of(Bound *bound, PyObject *q, PyObject *out) {
    int64_t copy[MOST_SLOTS], good;
    npy_intp rows = bound->numbers[0], columns = bound->numbers[1];
    if (!is_vector(q, bound->n)) return NULL;
    if (!out) {
        out = new_array(2, rows, columns);
        if (!out) return NULL;
    } else if (is_matrix(out, rows, columns, 1)) {
        Py_INCREF(out);
    } else {
        return NULL;
    }
    int64_t *slots = slots_of(bound, copy);
    put_matrix(put_vector(slots + bound->n_slots, data_of(q), bound->n), data_of(out), rows, columns);
    if (!run_machine_code(bound->entry, bound->overload, slots, &good) && good) return out;
    Py_DECREF(out);
    return NULL;
}

PyObject *truth_of(Bound *bound, PyObject *q, const int64_t *span) {
    int64_t copy[MOST_SLOTS], code;
    if (!is_vector(q, bound->n)) return NULL;
    int64_t *slots = slots_of_scene(bound, copy, span);
    put_vector(slots + bound->n_slots, data_of(q), bound->n);
    if (run_machine_code(bound->entry, bound->overload, slots, &code)) return NULL;
    if (code == bound->numbers[0]) Py_RETURN_FALSE;
    if (code == bound->numbers[1]) Py_RETURN_TRUE;
    return NULL;
}

PyObject *number_of(Bound *bound, PyObject *q, const int64_t *span) {
    int64_t copy[MOST_SLOTS], good;
    double record[MOST_SCRATCH];
    if (!is_vector(q, bound->n)) return NULL;
    int64_t *slots = slots_of_scene(bound, copy, span);
    put_vector(put_matrix(slots + bound->n_slots, data_of(q), 1, bound->n), record, 1);
    if (run_machine_code(bound->entry, bound->overload, slots, &good) || !good) return NULL;
    return PyFloat_FromDouble(record[0]);
}

int edge_of(Bound *bound, PyObject *q_a, PyObject *q_b, double resolution, const int64_t *span, double *free_until, PyObject **q) {
    int64_t copy[MOST_SLOTS], good, status[1] = {0};
    npy_intp n = bound->n;
    if (!is_vector(q_a, n) || !is_vector(q_b, n)) return -1;
    int64_t *slots = slots_of_scene(bound, copy, span), *next = put_matrix(slots + bound->n_slots, data_of(q_a), 1, n);
    next = put_matrix(next, data_of(q_b), 1, n);
    memcpy(next, &resolution, sizeof resolution);
    put_vector(put_vector(next + 1, status, 1), free_until, 1);
    if (run_machine_code(bound->entry, bound->overload, slots, &good) || !good) return -1;
    if (status[0] != bound->numbers[0] && status[0] != bound->numbers[1]) return -1;
    if (!(*q = new_array(1, n, 0))) return -1;
    const double *a = data_of(q_a), *b = data_of(q_b);
    for (npy_intp k = 0; k < n; k++) ((double *)data_of(*q))[k] = a[k] + *free_until * (b[k] - a[k]); /* not contracted: hatch_build */
    return status[0] == bound->numbers[1];
}

static PyObject *copy_of(Bound *bound, PyObject *T) {
    int64_t copy[MOST_SLOTS], good;
    npy_intp rows = bound->numbers[0], columns = bound->numbers[1];
    PyObject *out = is_matrix(T, rows, columns, 0) ? new_array(2, rows, columns) : NULL;
    if (!out) return NULL;
    int64_t *slots = slots_of(bound, copy);
    put_matrix(put_matrix(slots + bound->n_slots, data_of(T), rows, columns), data_of(out), rows, columns);
    if (!run_machine_code(bound->entry, bound->overload, slots, &good) && good) return out;
    Py_DECREF(out);
    return NULL;
}

int search_of(Bound *bound, PyObject *target, PyObject *seed, PyObject **q, PyObject **info) {
    int64_t copy[MOST_SLOTS], good;
    if (!is_matrix(target, 4, 4, 0) || !is_vector(seed, bound->n)) return -2;
    *q = new_array(1, bound->n, 0);
    *info = new_record_like(bound->like);
    if (*q && *info) {
        int64_t *slots = slots_of(bound, copy), *next = put_matrix(slots + bound->n_slots, data_of(target), 4, 4);
        next = put_vector(next, data_of(seed), bound->n);
        next = put_matrix(next, data_of(*q), 1, bound->n);
        put_vector(next, data_of(*info), 1);
        int failed = run_machine_code(bound->entry, bound->overload, slots, &good);
        if (!failed && good) return 1;
    }
    Py_CLEAR(*q);
    Py_CLEAR(*info);
    return PyErr_Occurred() ? -1 : 0;
}

static PyObject *read_only(PyObject *array) {
    if (array) PyArray_CLEARFLAGS((PyArrayObject *)array, NPY_ARRAY_WRITEABLE);
    return array;
}

static PyObject *truths_of(const npy_bool *row, npy_intp n) {
    PyObject *array = new_array_of(NPY_BOOL, 1, n, 0);
    if (array) memcpy(data_of(array), row, n);
    return read_only(array);
}

int branches_of(Bound *bound, PyObject *target, PyObject **q, PyObject **valid, PyObject **real) {
    int64_t copy[MOST_SLOTS], code = -1;
    npy_bool truths[2 * MOST_SCRATCH];
    npy_intp n = bound->numbers[0];
    *valid = *real = NULL;
    if (!is_matrix(target, 4, 4, 0) || !(*q = new_array(2, n, bound->n))) return -1;
    int64_t *slots = slots_of(bound, copy), *next = put_matrix(slots + bound->n_slots, data_of(target), 4, 4);
    put_matrix(put_matrix(next, data_of(*q), n, bound->n), truths, 2, n);
    if (!run_machine_code(bound->entry, bound->overload, slots, &code) && code >= 0 && code < bound->numbers[1]) {
        read_only(*q);
        *valid = truths_of(truths, n);
        *real = truths_of(truths + n, n);
        if (*valid && *real) return (int)code;
    }
    Py_CLEAR(*q);
    Py_CLEAR(*valid);
    Py_CLEAR(*real);
    return -1;
}

/* ---- the same as functions that Python calls ---- */

PyObject *call_with(PyObject *function, PyObject *first, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    Py_ssize_t n_names = names ? PyTuple_Size(names) : 0, shift = first ? 1 : 0;
    PyObject *given = PyTuple_New(n + shift), *named = n_names ? PyDict_New() : NULL, *result = NULL;
    if (!given || (n_names && !named)) goto end;
    if (first) PyTuple_SetItem(given, 0, Py_NewRef(first));
    for (Py_ssize_t k = 0; k < n; k++) PyTuple_SetItem(given, k + shift, Py_NewRef(arguments[k]));
    for (Py_ssize_t k = 0; k < n_names; k++) {
        if (PyDict_SetItem(named, PyTuple_GetItem(names, k), arguments[n + k])) goto end;
    }
    result = PyObject_Call(function, given, named);
end:
    Py_XDECREF(given);
    Py_XDECREF(named);
    return result;
}

static PyObject *or_in_python(PyObject *result, Bound *bound, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    if (result || PyErr_Occurred()) return result;
    return call_with(bound->otherwise, NULL, arguments, n, names);
}

static PyObject *call_pose(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    Bound *bound = (Bound *)self;
    PyObject *out = n > 1 && arguments[1] != Py_None ? arguments[1] : NULL;
    int plain = !names && (n == 1 || n == 2);
    PyObject *result = plain ? pose_of(bound, arguments[0], out) : NULL;
    return or_in_python(result, bound, arguments, n, names);
}

static PyObject *call_truth(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    Bound *bound = (Bound *)self;
    return or_in_python(!names && n == 1 ? truth_of(bound, arguments[0], NULL) : NULL, bound, arguments, n, names);
}

static PyObject *call_number(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    Bound *bound = (Bound *)self;
    return or_in_python(!names && n == 1 ? number_of(bound, arguments[0], NULL) : NULL, bound, arguments, n, names);
}

static PyObject *call_edge(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    Bound *bound = (Bound *)self;
    PyObject *q;
    double free_until;
    int touches = !names && n == 3 && PyFloat_Check(arguments[2])
        ? edge_of(bound, arguments[0], arguments[1], PyFloat_AsDouble(arguments[2]), NULL, &free_until, &q) : -1;
    if (touches < 0) return or_in_python(NULL, bound, arguments, n, names);
    return Py_BuildValue("NdN", PyBool_FromLong(touches), free_until, q);
}

static PyObject *call_copy(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    Bound *bound = (Bound *)self;
    return or_in_python(!names && n == 1 ? copy_of(bound, arguments[0]) : NULL, bound, arguments, n, names);
}

static PyObject *call_search(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    Bound *bound = (Bound *)self;
    PyObject *q, *info, *both;
    int found = names || n != 2 ? -2 : search_of(bound, arguments[0], arguments[1], &q, &info);
    if (found == -2) return call_with(bound->otherwise, NULL, arguments, n, names);
    if (found < 0) return NULL;
    if (!found) Py_RETURN_NONE;
    both = PyTuple_Pack(2, q, info);
    Py_DECREF(q);
    Py_DECREF(info);
    return both;
}

static PyObject *call_branches(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    Bound *bound = (Bound *)self;
    PyObject *q, *valid, *real;
    int code = !names && n == 1 ? branches_of(bound, arguments[0], &q, &valid, &real) : -1;
    return code < 0 ? or_in_python(NULL, bound, arguments, n, names) : Py_BuildValue("NNNi", q, valid, real, code);
}

const Way POSE = {"pose", call_pose, "12", 'b', 2};
const Way TRUTH = {"truth", call_truth, "1", 'i', 2};
const Way NUMBER = {"number", call_number, "2r", 'b', 0};
const Way EDGE = {"edge", call_edge, "22di1", 'b', 2};
const Way COPY = {"copy", call_copy, "22", 'b', 2};
const Way SEARCH = {"search", call_search, "212r", 'b', 0};
const Way BRANCHES = {"branches", call_branches, "22t", 'i', 2};

const Way *way_of(const char *name) {
    static const Way *const ways[] = {&POSE, &TRUTH, &NUMBER, &EDGE, &COPY, &SEARCH, &BRANCHES};
    for (size_t k = 0; k < sizeof ways / sizeof *ways; k++) {
        if (!strcmp(ways[k]->name, name)) return ways[k];
    }
    return NULL;
}
