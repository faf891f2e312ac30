/* The class Bound (engine/bound.py): an entry with bound leading arguments, called with one q, or with one target.

It checks the type, elements, shape and flags of q, allocates the result, and calls the machine code. Unsuitable arguments, and a q
that the machine code refuses, go unchanged to another callable: Python's own path, which converts them or raises an error that names
them. The way (ways.c) defines the arguments and the result. Classes in Python may inherit it.
*/
#include "bound.h"

#include <string.h>

/* Whether the leading arguments fit an overload, followed by the way's own arguments; writes their slots to ``bound``. */
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
        int64_t slots[MAX_SLOTS];
        if (*axes == 'r') {
            if (kind->what != 'a' || kind->type != NPY_VOID || take_argument(kind, bound->like, slots) < 0) return 0;
            if (way == &NUMBER && kind->size > (int)sizeof(double) * MAX_SCRATCH) return 0;
            continue;
        }
        int dimensions = *axes == 't' ? 2 : *axes == 'i' ? 1 : *axes - '0';
        int type = *axes == 't' ? NPY_BOOL : *axes == 'i' ? NPY_INT64 : NPY_DOUBLE;
        if (*axes == 'd' ? kind->what != 'd' : kind->what != 'a' || kind->dimensions != dimensions || kind->type != type) return 0;
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
    PyErr_Format(PyExc_TypeError, "%s was not compiled for these argument types, or has another result type", bound->entry->name);
    return -1;
}

static int read_numbers(Bound *bound, const Way *way, PyObject *numbers) {
    if (PyTuple_Size(numbers) != way->n_numbers) return PyErr_SetString(PyExc_ValueError, "wrong count of numbers"), -1;
    for (int k = 0; k < way->n_numbers; k++) {
        bound->numbers[k] = PyNumber_AsSsize_t(PyTuple_GetItem(numbers, k), PyExc_OverflowError);
        if (PyErr_Occurred()) return -1;
        int is_size = way != &TRUTH && way != &EDGE, in_scratch = way == &BRANCHES;
        if (is_size && (bound->numbers[k] < 1 || (in_scratch && bound->numbers[k] > MAX_SCRATCH))) {
            return PyErr_SetString(PyExc_ValueError, "a size out of range"), -1;
        }
    }
    return 0;
}

/* ---- the class ---- */

static int visit(PyObject *self, visitproc visit, void *arg) {
    Bound *bound = (Bound *)self;
    Py_VISIT(Py_TYPE(self));
    Py_VISIT(bound->leading);
    Py_VISIT(bound->otherwise);
    Py_VISIT(bound->like);
    return 0;
}

static int clear(PyObject *self) {
    Bound *bound = (Bound *)self;
    Py_CLEAR(bound->entry);
    Py_CLEAR(bound->leading);
    Py_CLEAR(bound->otherwise);
    Py_CLEAR(bound->like);
    return 0;
}

static void free_bound(PyObject *self) {
    PyTypeObject *type = Py_TYPE(self);
    PyObject_GC_UnTrack(self);
    clear(self);
    ((freefunc)PyType_GetSlot(type, Py_tp_free))(self);
    Py_DECREF(type);
}

/* Bound(entry, way, leading, n, numbers, otherwise, like=None): see engine/bound.py. */
static int init(PyObject *self, PyObject *arguments, PyObject *named) {
    Bound *bound = (Bound *)self;
    PyObject *entry, *leading, *numbers, *otherwise, *like = Py_None, *of_entry;
    const char *name;
    Py_ssize_t n;
    if (named && PyDict_Size(named)) return PyErr_SetString(PyExc_TypeError, "arguments by position are expected"), -1;
    if (!PyArg_ParseTuple(arguments, "OsO!nO!O|O", &entry, &name, &PyTuple_Type, &leading, &n, &PyTuple_Type, &numbers, &otherwise,
                          &like)) {
        return -1;
    }
    const Way *way = way_of(name);
    of_entry = PyCFunction_Check(entry) ? PyCFunction_GetSelf(entry) : NULL;
    if (entry != Py_None && (!of_entry || Py_TYPE(of_entry) != entry_type)) {
        return PyErr_SetString(PyExc_TypeError, "an entry is expected"), -1;
    }
    if (!way || (of_entry && n < 1) || !PyCallable_Check(otherwise)) {
        return PyErr_SetString(PyExc_ValueError, "a way, a number of entries of q and a callable are expected"), -1;
    }
    if (bound->otherwise) return PyErr_SetString(PyExc_TypeError, "a bound entry cannot be changed"), -1;
    bound->way = way;
    bound->leading = Py_NewRef(leading);
    bound->like = Py_NewRef(like);
    bound->n = n;
    if (of_entry) {
        bound->entry = (Entry *)Py_NewRef(of_entry);
        if (read_numbers(bound, way, numbers) || choose_overload(bound, way)) return clear(self), -1;
    }
    bound->otherwise = Py_NewRef(otherwise);
    return 0;
}

/* The arguments of a call in order; only ``out`` may be named. Returns their number, or 0 if Python must process them. */
static Py_ssize_t read_arguments(const Way *way, PyObject *arguments, PyObject *named, PyObject **given) {
    Py_ssize_t n = PyTuple_Size(arguments);
    if (n < 1 || n > MAX_ARGUMENTS) return 0;
    for (Py_ssize_t k = 0; k < n; k++) given[k] = PyTuple_GetItem(arguments, k);
    if (!named || !PyDict_Size(named)) return n;
    if (!way->takes_out || n != 1 || PyDict_Size(named) != 1) return 0;
    given[1] = PyDict_GetItemString(named, "out");
    return given[1] ? 2 : 0;
}

static PyObject *call(PyObject *self, PyObject *arguments, PyObject *named) {
    Bound *bound = (Bound *)self;
    PyObject *given[MAX_ARGUMENTS];
    Py_ssize_t n = bound->entry ? read_arguments(bound->way, arguments, named, given) : 0;
    PyObject *result = n ? bound->way->call(bound, given, n) : NULL;
    if (result || PyErr_Occurred()) return result;
    if (!bound->otherwise) return PyErr_SetString(PyExc_TypeError, "the entry has no bound arguments"), NULL;
    return PyObject_Call(bound->otherwise, arguments, named);
}

static PyType_Slot slots_of_type[] = {{Py_tp_dealloc, free_bound}, {Py_tp_traverse, visit}, {Py_tp_clear, clear},
                                      {Py_tp_init, init}, {Py_tp_call, call}, {0, NULL}};
PyType_Spec bound_spec = {"ulna.engine._calls.Bound", sizeof(Bound), 0,
                          Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_BASETYPE, slots_of_type};
