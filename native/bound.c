/* A bound function: an entry with its leading arguments kept, called with one q, or with one target.

It looks at q by its type, its elements, its shape and its flags, makes the answer, and calls the machine code. Whatever is not as it
should be, and a q that the machine code refuses, goes to another callable with the arguments as they were: Python's own way, which
converts or refuses by name. What it takes and returns is its way (ways.c).
*/
#include "bound.h"

#include <string.h>

PyTypeObject *bound_type;

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
        int64_t slots[MOST_SLOTS];
        if (*axes == 'r') {
            if (kind->what != 'a' || kind->type != NPY_VOID || take_argument(kind, bound->like, slots) < 0) return 0;
            if (way == &NUMBER && kind->size > (int)sizeof(double) * MOST_SCRATCH) return 0;
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
    PyErr_Format(PyExc_TypeError, "%s was not compiled for such arguments, or returns something else", bound->entry->name);
    return -1;
}

static int read_numbers(Bound *bound, const Way *way, PyObject *numbers) {
    if (PyTuple_Size(numbers) != way->n_numbers) return PyErr_SetString(PyExc_ValueError, "too few numbers, or too many"), -1;
    for (int k = 0; k < way->n_numbers; k++) {
        bound->numbers[k] = PyNumber_AsSsize_t(PyTuple_GetItem(numbers, k), PyExc_OverflowError);
        if (PyErr_Occurred()) return -1;
        int is_size = way != &TRUTH && way != &EDGE, in_scratch = way == &BRANCHES;
        if (is_size && (bound->numbers[k] < 1 || (in_scratch && bound->numbers[k] > MOST_SCRATCH))) {
            return PyErr_SetString(PyExc_ValueError, "a size out of range"), -1;
        }
    }
    return 0;
}

PyObject *bind_entry(PyObject *module, PyObject *arguments) {
    PyObject *entry, *leading, *numbers, *otherwise, *like = Py_None, *of_entry, *function = NULL;
    const char *name;
    Py_ssize_t n;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "OsO!nO!O|O", &entry, &name, &PyTuple_Type, &leading, &n, &PyTuple_Type, &numbers, &otherwise,
                          &like)) {
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
    Py_INCREF(like);
    bound->way = way;
    bound->entry = (Entry *)of_entry;
    bound->leading = leading;
    bound->otherwise = otherwise;
    bound->like = like;
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

Bound *bound_of(PyObject *function, const Way *way) {
    PyObject *self = PyCFunction_Check(function) ? PyCFunction_GetSelf(function) : NULL;
    if (!self || Py_TYPE(self) != bound_type || ((Bound *)self)->way != way) return NULL;
    return (Bound *)self;
}

static int visit_bound(PyObject *self, visitproc visit, void *arg) {
    Bound *bound = (Bound *)self;
    Py_VISIT(Py_TYPE(self));
    Py_VISIT(bound->leading);
    Py_VISIT(bound->otherwise);
    Py_VISIT(bound->like);
    return 0;
}

static void free_bound(PyObject *self) {
    Bound *bound = (Bound *)self;
    PyTypeObject *type = Py_TYPE(self);
    PyObject_GC_UnTrack(self);
    Py_XDECREF((PyObject *)bound->entry);
    Py_XDECREF(bound->leading);
    Py_XDECREF(bound->otherwise);
    Py_XDECREF(bound->like);
    PyObject_GC_Del(self);
    Py_DECREF(type);
}

static PyType_Slot slots_of_type[] = {{Py_tp_dealloc, free_bound}, {Py_tp_traverse, visit_bound}, {0, NULL}};
PyType_Spec bound_spec = {"ulna.engine._calls.Bound", sizeof(Bound), 0,
                          Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots_of_type};
