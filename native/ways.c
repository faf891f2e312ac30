/* The eight ways of a bound function: its arguments, the arrays that it allocates, and its result.

    pose      f(q, out=None)                entry(*leading, q, out) -> bool; an array of the shape ``numbers``
    truth     f(q, first, end)              entry(*leading, q) -> int; False or True for the two codes in ``numbers``
    number    f(q, first, end)              entry(*leading, q[None], record) -> bool; the first number of the record
    edge      f(q_a, q_b, resolution,       entry(*leading, q_a[None], q_b[None], resolution, status, free) -> bool; False or True
                first, end)                 for the two codes in ``numbers``, the free fraction, and q there
    motion    f(q, qd, qdd)                 entry(*leading, q, qd, qdd, out) -> bool; an array of ``numbers`` numbers
    copy      f(T)                          entry(*leading, T, out) -> bool; an array of the shape ``numbers``, which T has too
    search    f(target, seed)               entry(*leading, target, seed, q, info) -> bool; q and info, an array of one record,
                                            or None without a solution
    branches  f(target)                     entry(*leading, target, q, truths) -> int; q, both rows of bools, and the code; or None if
                                            the code proves nothing. ``numbers``: the number of branches, and of codes with a proof

``first`` and ``end`` replace those of the bound scene: the rows of the objects outside the BVH.
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
    return PyArray_NewFromDescr(&PyArray_Type, elements, dimensions, shape, NULL, NULL, 0, NULL); /* SimpleNew runs more checks first */
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

/* The slots of a call: the bound ones, and memory for the rest, whose number ``bind`` has checked. If the machine code keeps the
   interpreter's lock, they are the bound function's own; otherwise a copy, since another thread may call it at the same time. */
static int64_t *slots_of(Bound *bound, int64_t *copy) {
    if (!bound->entry->releases_lock) return bound->slots;
    return memcpy(copy, bound->slots, bound->n_slots * sizeof *copy);
}

/* A copy of the slots of a scene, with the call's rows of objects, first and end. NULL if they are no numbers. */
static int64_t *slots_of_scene(Bound *bound, int64_t *copy, PyObject *const *rows) {
    memcpy(copy, bound->slots, bound->n_slots * sizeof *copy);
    int64_t *place = copy + bound->n_slots - ROWS_TO_END;
    for (int k = 0; k < 2; k++) {
        if (!PyLong_Check(rows[k])) return NULL;
        place[k] = PyLong_AsLongLong(rows[k]);
    }
    return PyErr_Occurred() ? NULL : copy;
}

/* ---- the eight ways ---- */

static PyObject *call_pose(Bound *bound, PyObject *const *arguments, Py_ssize_t n) {
    int64_t copy[MAX_SLOTS], good;
    npy_intp rows = bound->numbers[0], columns = bound->numbers[1];
    PyObject *q = arguments[0], *out = n > 1 && arguments[1] != Py_None ? arguments[1] : NULL;
    if (n > 2 || !is_vector(q, bound->n)) return NULL;
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

static PyObject *call_truth(Bound *bound, PyObject *const *arguments, Py_ssize_t n) {
    int64_t copy[MAX_SLOTS], code;
    if (n != 3 || !is_vector(arguments[0], bound->n)) return NULL;
    int64_t *slots = slots_of_scene(bound, copy, arguments + 1);
    if (!slots) return NULL;
    put_vector(slots + bound->n_slots, data_of(arguments[0]), bound->n);
    if (run_machine_code(bound->entry, bound->overload, slots, &code)) return NULL;
    if (code == bound->numbers[0]) Py_RETURN_FALSE;
    if (code == bound->numbers[1]) Py_RETURN_TRUE;
    return NULL;
}

static PyObject *call_number(Bound *bound, PyObject *const *arguments, Py_ssize_t n) {
    int64_t copy[MAX_SLOTS], good;
    double record[MAX_SCRATCH];
    if (n != 3 || !is_vector(arguments[0], bound->n)) return NULL;
    int64_t *slots = slots_of_scene(bound, copy, arguments + 1);
    if (!slots) return NULL;
    put_vector(put_matrix(slots + bound->n_slots, data_of(arguments[0]), 1, bound->n), record, 1);
    if (run_machine_code(bound->entry, bound->overload, slots, &good) || !good) return NULL;
    return PyFloat_FromDouble(record[0]);
}

static PyObject *call_edge(Bound *bound, PyObject *const *arguments, Py_ssize_t n) {
    int64_t copy[MAX_SLOTS], good, status[1] = {0};
    double free_until[1];
    if (n != 5) return NULL;
    PyObject *q_a = arguments[0], *q_b = arguments[1], *q;
    if (!is_vector(q_a, bound->n) || !is_vector(q_b, bound->n) || !PyFloat_Check(arguments[2])) return NULL;
    double resolution = PyFloat_AsDouble(arguments[2]);
    int64_t *slots = slots_of_scene(bound, copy, arguments + 3);
    if (!slots) return NULL;
    int64_t *next = put_matrix(put_matrix(slots + bound->n_slots, data_of(q_a), 1, bound->n), data_of(q_b), 1, bound->n);
    memcpy(next, &resolution, sizeof resolution);
    put_vector(put_vector(next + 1, status, 1), free_until, 1);
    if (run_machine_code(bound->entry, bound->overload, slots, &good) || !good) return NULL;
    if ((status[0] != bound->numbers[0] && status[0] != bound->numbers[1]) || !(q = new_array(1, bound->n, 0))) return NULL;
    const double *a = data_of(q_a), *b = data_of(q_b);
    for (npy_intp k = 0; k < bound->n; k++) {
        ((double *)data_of(q))[k] = a[k] + *free_until * (b[k] - a[k]); /* not contracted: hatch_build */
    }
    return Py_BuildValue("NdN", PyBool_FromLong(status[0] == bound->numbers[1]), *free_until, q);
}

static PyObject *call_motion(Bound *bound, PyObject *const *arguments, Py_ssize_t n) {
    int64_t copy[MAX_SLOTS], good;
    if (n != 3) return NULL;
    for (int k = 0; k < 3; k++) {
        if (!is_vector(arguments[k], bound->n)) return NULL;
    }
    PyObject *out = new_array(1, bound->numbers[0], 0);
    if (!out) return NULL;
    int64_t *slots = slots_of(bound, copy), *next = slots + bound->n_slots;
    for (int k = 0; k < 3; k++) next = put_vector(next, data_of(arguments[k]), bound->n);
    put_vector(next, data_of(out), bound->numbers[0]);
    if (!run_machine_code(bound->entry, bound->overload, slots, &good) && good) return out;
    Py_DECREF(out);
    return NULL;
}

static PyObject *call_copy(Bound *bound, PyObject *const *arguments, Py_ssize_t n) {
    int64_t copy[MAX_SLOTS], good;
    npy_intp rows = bound->numbers[0], columns = bound->numbers[1];
    PyObject *T = arguments[0], *out = n == 1 && is_matrix(T, rows, columns, 0) ? new_array(2, rows, columns) : NULL;
    if (!out) return NULL;
    int64_t *slots = slots_of(bound, copy);
    put_matrix(put_matrix(slots + bound->n_slots, data_of(T), rows, columns), data_of(out), rows, columns);
    if (!run_machine_code(bound->entry, bound->overload, slots, &good) && good) return out;
    Py_DECREF(out);
    return NULL;
}

static PyObject *call_search(Bound *bound, PyObject *const *arguments, Py_ssize_t n) {
    int64_t copy[MAX_SLOTS], good;
    if (n != 2 || !is_matrix(arguments[0], 4, 4, 0) || !is_vector(arguments[1], bound->n)) return NULL;
    PyObject *q = new_array(1, bound->n, 0), *info = new_record_like(bound->like);
    if (q && info) {
        int64_t *slots = slots_of(bound, copy), *next = put_matrix(slots + bound->n_slots, data_of(arguments[0]), 4, 4);
        next = put_vector(next, data_of(arguments[1]), bound->n);
        next = put_matrix(next, data_of(q), 1, bound->n);
        put_vector(next, data_of(info), 1);
        int failed = run_machine_code(bound->entry, bound->overload, slots, &good);
        if (!failed && good) return Py_BuildValue("NN", q, info);
    }
    Py_XDECREF(q);
    Py_XDECREF(info);
    if (PyErr_Occurred()) return NULL;
    Py_RETURN_NONE;
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

static PyObject *call_branches(Bound *bound, PyObject *const *arguments, Py_ssize_t n) {
    int64_t copy[MAX_SLOTS], code = -1;
    npy_bool truths[2 * MAX_SCRATCH];
    npy_intp rows = bound->numbers[0];
    PyObject *q = n == 1 && is_matrix(arguments[0], 4, 4, 0) ? new_array(2, rows, bound->n) : NULL;
    if (!q) return NULL;
    int64_t *slots = slots_of(bound, copy), *next = put_matrix(slots + bound->n_slots, data_of(arguments[0]), 4, 4);
    put_matrix(put_matrix(next, data_of(q), rows, bound->n), truths, 2, rows);
    if (!run_machine_code(bound->entry, bound->overload, slots, &code) && code >= 0 && code < bound->numbers[1]) {
        return Py_BuildValue("NNNi", read_only(q), truths_of(truths, rows), truths_of(truths + rows, rows), (int)code);
    }
    Py_DECREF(q);
    return NULL;
}

const Way POSE = {"pose", call_pose, "12", 'b', 2, 1};
const Way TRUTH = {"truth", call_truth, "1", 'i', 2, 0};
const Way NUMBER = {"number", call_number, "2r", 'b', 0, 0};
const Way EDGE = {"edge", call_edge, "22di1", 'b', 2, 0};
const Way MOTION = {"motion", call_motion, "1111", 'b', 1, 0};
const Way COPY = {"copy", call_copy, "22", 'b', 2, 0};
const Way SEARCH = {"search", call_search, "212r", 'b', 0, 0};
const Way BRANCHES = {"branches", call_branches, "22t", 'i', 2, 0};

const Way *way_of(const char *name) {
    static const Way *const ways[] = {&POSE, &TRUTH, &NUMBER, &EDGE, &MOTION, &COPY, &SEARCH, &BRANCHES};
    for (size_t k = 0; k < sizeof ways / sizeof *ways; k++) {
        if (!strcmp(ways[k]->name, name)) return ways[k];
    }
    return NULL;
}
