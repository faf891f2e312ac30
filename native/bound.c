/* A bound function: an entry with its leading arguments kept, called with one q, or with one target.

It looks at q by its type, its elements, its shape and its flags, makes the answer, and calls the machine code. Whatever is not as it
should be, and a q that the machine code refuses, goes to another callable with the arguments as they were: Python's own way, which
converts or refuses by name. There are four ways:

    pose      f(q, out=None, threads=None)  entry(*leading, q, out) -> bool; an array of the shape ``numbers``
    truth     f(q)                          entry(*leading, q) -> int; False or True for the two codes in ``numbers``
    number    f(q)                          entry(*leading, q[None], scratch) -> bool; the first of as many as ``numbers`` says
    search    f(target, seed)               entry(*leading, target, seed, q, info) -> bool; q and info, of as many as ``numbers`` says,
                                            or None if there is no solution
*/
#include "bound.h"

#include <string.h>

#define MOST_SCRATCH 16

PyTypeObject *bound_type;

typedef struct {
    PyObject_HEAD
    PyMethodDef method;
    Entry *entry;
    const Overload *overload;
    PyObject *leading;   /* what the slots point into */
    PyObject *otherwise;
    int n_slots;
    npy_intp n;          /* entries of q */
    npy_intp numbers[2];
    int64_t slots[MOST_SLOTS];
} Bound;

/* ---- slots ---- */

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

static PyObject *new_array(int dimensions, npy_intp rows, npy_intp columns) {
    npy_intp shape[2] = {rows, columns};
    return PyArray_SimpleNew(dimensions, shape, NPY_DOUBLE);
}

/* The slots of a call: those bound, and room for the rest, which ``bind`` has counted. */
static int64_t *begin(const Bound *bound, int64_t *slots) {
    memcpy(slots, bound->slots, bound->n_slots * sizeof *slots);
    return slots + bound->n_slots;
}

static PyObject *go_otherwise(const Bound *bound, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    Py_ssize_t n_names = names ? PyTuple_Size(names) : 0;
    PyObject *given = PyTuple_New(n), *named = n_names ? PyDict_New() : NULL, *result = NULL;
    if (!given || (n_names && !named)) goto end;
    for (Py_ssize_t k = 0; k < n; k++) {
        Py_INCREF(arguments[k]);
        PyTuple_SetItem(given, k, arguments[k]);
    }
    for (Py_ssize_t k = 0; k < n_names; k++) {
        if (PyDict_SetItem(named, PyTuple_GetItem(names, k), arguments[n + k])) goto end;
    }
    result = PyObject_Call(bound->otherwise, given, named);
end:
    Py_XDECREF(given);
    Py_XDECREF(named);
    return result;
}

/* ---- the four ways ---- */

static PyObject *call_pose(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    const Bound *bound = (Bound *)self;
    int64_t slots[MOST_SLOTS], good;
    if (names || n < 1 || n > 3 || !is_vector(arguments[0], bound->n)) return go_otherwise(bound, arguments, n, names);
    PyObject *out = n > 1 && arguments[1] != Py_None ? arguments[1] : NULL;
    if (!out) {
        out = new_array(2, bound->numbers[0], bound->numbers[1]);
        if (!out) return NULL;
    } else if (is_matrix(out, bound->numbers[0], bound->numbers[1], 1)) {
        Py_INCREF(out);
    } else {
        return go_otherwise(bound, arguments, n, names);
    }
    int64_t *next = put_vector(begin(bound, slots), data_of(arguments[0]), bound->n);
    put_matrix(next, data_of(out), bound->numbers[0], bound->numbers[1]);
    if (run_machine_code(bound->entry, bound->overload, slots, &good)) {
        Py_DECREF(out);
        return NULL;
    }
    if (good) return out;
    Py_DECREF(out);
    return go_otherwise(bound, arguments, n, names);
}

static PyObject *call_truth(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    const Bound *bound = (Bound *)self;
    int64_t slots[MOST_SLOTS], code;
    if (!names && n == 1 && is_vector(arguments[0], bound->n)) {
        put_vector(begin(bound, slots), data_of(arguments[0]), bound->n);
        if (run_machine_code(bound->entry, bound->overload, slots, &code)) return NULL;
        if (code == bound->numbers[0]) Py_RETURN_FALSE;
        if (code == bound->numbers[1]) Py_RETURN_TRUE;
    }
    return go_otherwise(bound, arguments, n, names);
}

static PyObject *call_number(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    const Bound *bound = (Bound *)self;
    int64_t slots[MOST_SLOTS], good;
    double scratch[MOST_SCRATCH];
    if (!names && n == 1 && is_vector(arguments[0], bound->n)) {
        int64_t *next = put_matrix(begin(bound, slots), data_of(arguments[0]), 1, bound->n);
        put_matrix(next, scratch, 1, bound->numbers[0]);
        if (run_machine_code(bound->entry, bound->overload, slots, &good)) return NULL;
        if (good) return PyFloat_FromDouble(scratch[0]);
    }
    return go_otherwise(bound, arguments, n, names);
}

static PyObject *call_search(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    const Bound *bound = (Bound *)self;
    int64_t slots[MOST_SLOTS], good;
    if (names || n != 2 || !is_matrix(arguments[0], 4, 4, 0) || !is_vector(arguments[1], bound->n)) {
        return go_otherwise(bound, arguments, n, names);
    }
    PyObject *q = new_array(1, bound->n, 0), *info = new_array(2, 1, bound->numbers[0]), *both = NULL;
    if (q && info) {
        int64_t *next = put_matrix(begin(bound, slots), data_of(arguments[0]), 4, 4);
        next = put_vector(next, data_of(arguments[1]), bound->n);
        next = put_matrix(next, data_of(q), 1, bound->n);
        put_matrix(next, data_of(info), 1, bound->numbers[0]);
        if (!run_machine_code(bound->entry, bound->overload, slots, &good)) {
            both = good ? PyTuple_Pack(2, q, info) : Py_NewRef(Py_None);
        }
    }
    Py_XDECREF(q);
    Py_XDECREF(info);
    return both;
}

/* ---- making one ---- */

typedef PyObject *(*Call)(PyObject *, PyObject *const *, Py_ssize_t, PyObject *);
typedef struct {
    const char *name;
    Call call;
    const char *rest; /* the kinds that follow the leading arguments: arrays of float64, by their number of axes */
    char result;
    int n_numbers;
} Way;
static const Way ways[] = {
    {"pose", call_pose, "12", 'b', 2},
    {"truth", call_truth, "1", 'i', 2},
    {"number", call_number, "22", 'b', 1},
    {"search", call_search, "2122", 'b', 1},
};

static const Way *way_of(const char *name) {
    for (size_t k = 0; k < sizeof ways / sizeof *ways; k++) {
        if (!strcmp(ways[k].name, name)) return &ways[k];
    }
    return NULL;
}

/* Whether the leading arguments fit an overload and the way's own arguments follow; then their slots are in ``bound``. */
static int fits(Bound *bound, const Overload *overload, const Way *way) {
    const Kind *kind = overload->kinds;
    Py_ssize_t n = PyTuple_Size(bound->leading);
    if (overload->n_arguments != n + (Py_ssize_t)strlen(way->rest)) return 0;
    for (Py_ssize_t k = 0; k < n; k++) {
        int used = take_argument(kind, PyTuple_GetItem(bound->leading, k), bound->slots + bound->n_slots);
        if (used < 0) return 0;
        bound->n_slots += used;
        kind += kinds_of(kind);
    }
    for (const char *axes = way->rest; *axes; axes++, kind++) {
        if (kind->what != 'a' || kind->dimensions != *axes - '0' || kind->type != NPY_DOUBLE) return 0;
    }
    return 1;
}

static int choose_overload(Bound *bound, const Way *way) {
    if (bound->entry->result == way->result) {
        for (int k = 0; k < bound->entry->n_overloads; k++) {
            bound->n_slots = 0;
            bound->overload = &bound->entry->overloads[k];
            if (fits(bound, bound->overload, way)) return 0;
        }
    }
    PyErr_Format(PyExc_TypeError, "%s was not compiled for such arguments, or returns something else", bound->entry->name);
    return -1;
}

static int read_numbers(Bound *bound, const Way *way, PyObject *numbers) {
    if (PyTuple_Size(numbers) != way->n_numbers) return PyErr_SetString(PyExc_ValueError, "too few numbers, or too many"), -1;
    for (int k = 0; k < way->n_numbers; k++) {
        bound->numbers[k] = PyNumber_AsSsize_t(PyTuple_GetItem(numbers, k), PyExc_OverflowError);
        if (PyErr_Occurred()) return -1;
        int is_size = way->call != call_truth;
        if (is_size && (bound->numbers[k] < 1 || (way->call == call_number && bound->numbers[k] > MOST_SCRATCH))) {
            return PyErr_SetString(PyExc_ValueError, "a size out of range"), -1;
        }
    }
    return 0;
}

PyObject *bind(PyObject *module, PyObject *arguments) {
    PyObject *entry, *leading, *numbers, *otherwise, *of_entry, *function = NULL;
    const char *name;
    Py_ssize_t n;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OsO!nO!O", &entry, &name, &PyTuple_Type, &leading, &n, &PyTuple_Type, &numbers, &otherwise)) {
        return NULL;
    }
    const Way *way = way_of(name);
    of_entry = PyCFunction_Check(entry) ? PyCFunction_GetSelf(entry) : NULL;
    if (!of_entry || Py_TYPE(of_entry) != entry_type) return PyErr_SetString(PyExc_TypeError, "an entry is expected"), NULL;
    if (!way || n < 1 || !PyCallable_Check(otherwise)) {
        return PyErr_SetString(PyExc_ValueError, "a way, a number of entries of q and a callable are expected"), NULL;
    }
    Bound *bound = PyObject_GC_New(Bound, bound_type);
    if (!bound) return NULL;
    Py_INCREF(of_entry);
    Py_INCREF(leading);
    Py_INCREF(otherwise);
    bound->entry = (Entry *)of_entry;
    bound->leading = leading;
    bound->otherwise = otherwise;
    bound->n = n;
    if (!read_numbers(bound, way, numbers) && !choose_overload(bound, way)) {
        PyMethodDef method = {bound->entry->name, (PyCFunction)(void (*)(void))way->call, METH_FASTCALL | METH_KEYWORDS, NULL};
        bound->method = method;
        function = PyCFunction_NewEx(&bound->method, (PyObject *)bound, NULL);
    }
    PyObject_GC_Track(bound);
    Py_DECREF(bound);
    return function;
}

static int visit_bound(PyObject *self, visitproc visit, void *arg) {
    Bound *bound = (Bound *)self;
    Py_VISIT(Py_TYPE(self));
    Py_VISIT(bound->leading);
    Py_VISIT(bound->otherwise);
    return 0;
}

static void free_bound(PyObject *self) {
    Bound *bound = (Bound *)self;
    PyTypeObject *type = Py_TYPE(self);
    PyObject_GC_UnTrack(self);
    Py_XDECREF((PyObject *)bound->entry);
    Py_XDECREF(bound->leading);
    Py_XDECREF(bound->otherwise);
    PyObject_GC_Del(self);
    Py_DECREF(type);
}

static PyType_Slot slots_of_type[] = {{Py_tp_dealloc, free_bound}, {Py_tp_traverse, visit_bound}, {0, NULL}};
PyType_Spec bound_spec = {"ulna.engine._calls.Bound", sizeof(Bound), 0,
                          Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots_of_type};
