/* An entry: unpacks Python's arguments, calls machine code, and returns its number.

Each argument occupies slots of 8 bytes: a number one, an array its address and its shape, None none. Types are checked here. Shapes
are not: callers in Python have checked them, as for code compiled by Numba. */
#include "entry.h"

#include <stdio.h>
#include <string.h>

PyTypeObject *entry_type;

int kinds_of(const Kind *kind) { return kind->what == '(' ? 1 + kind->dimensions : 1; }

/* Whether the class and the size of an array's records are those that the machine code was compiled for. */
static int has_records(const Kind *kind, PyArrayObject *array) {
    PyObject *name = PyArray_ITEMSIZE(array) == kind->size ? PyType_GetName(PyArray_DESCR(array)->typeobj) : NULL;
    int same = name && PyUnicode_CompareWithASCIIString(name, kind->record) == 0;
    Py_XDECREF(name);
    PyErr_Clear();
    return same;
}

static int take_array(const Kind *kind, PyObject *argument, int64_t *slots) {
    if (!PyArray_CheckExact(argument)) return -1;
    PyArrayObject *array = (PyArrayObject *)argument;
    if (PyArray_NDIM(array) != kind->dimensions || PyArray_TYPE(array) != kind->type) return -1;
    if (kind->type == NPY_VOID && !has_records(kind, array)) return -1;
    if (!(kind->constant ? PyArray_ISCARRAY_RO(array) : PyArray_ISCARRAY(array))) return -1;
    slots[0] = (int64_t)(intptr_t)PyArray_DATA(array);
    for (int k = 0; k < kind->dimensions; k++) slots[1 + k] = PyArray_DIM(array, k);
    return 1 + kind->dimensions;
}

static int take_tuple(const Kind *kind, PyObject *argument, int64_t *slots) {
    if (!PyTuple_Check(argument) || PyTuple_Size(argument) != kind->dimensions) return -1;
    int used = 0;
    for (int k = 0; k < kind->dimensions; k++) {
        int n = take_argument(kind + 1 + k, PyTuple_GetItem(argument, k), slots + used);
        if (n < 0) return -1;
        used += n;
    }
    return used;
}

int take_argument(const Kind *kind, PyObject *argument, int64_t *slots) {
    double number;
    switch (kind->what) {
    case 'a':
        return take_array(kind, argument, slots);
    case 'i':
        if (!PyIndex_Check(argument) || PyArray_Check(argument)) return -1;
        slots[0] = PyNumber_AsSsize_t(argument, PyExc_OverflowError);
        break;
    case 'd':
        if (!PyFloat_Check(argument) && !PyLong_Check(argument)) return -1;
        number = PyFloat_AsDouble(argument);
        memcpy(slots, &number, sizeof number);
        break;
    case '-':
        return argument == Py_None ? 0 : -1;
    default:
        return take_tuple(kind, argument, slots);
    }
    if (PyErr_Occurred()) {
        PyErr_Clear();
        return -1;
    }
    return 1;
}

int run_machine_code(const Entry *entry, const Overload *overload, const int64_t *slots, int64_t *result) {
    int32_t failed;
    *result = 0;
    if (entry->releases_lock) {
        PyThreadState *state = PyEval_SaveThread();
        failed = overload->function(slots, result);
        PyEval_RestoreThread(state);
    } else {
        failed = overload->function(slots, result);
    }
    if (failed) PyErr_Format(PyExc_MemoryError, "%s: out of memory", entry->name);
    return failed ? -1 : 0;
}

static int take_arguments(const Overload *overload, PyObject *const *arguments, int64_t *slots) {
    const Kind *kind = overload->kinds;
    for (int k = 0; k < overload->n_arguments; k++) {
        int n = take_argument(kind, arguments[k], slots);
        if (n < 0) return -1 - k;
        slots += n;
        kind += kinds_of(kind);
    }
    return 0;
}

static PyObject *call_entry(PyObject *self, PyObject *const *arguments, Py_ssize_t n_arguments) {
    Entry *entry = (Entry *)self;
    int64_t slots[MAX_SLOTS], result;
    int refused = 0;
    for (int k = 0; k < entry->n_overloads; k++) {
        const Overload *overload = &entry->overloads[k];
        if (overload->n_arguments != n_arguments) continue;
        refused = take_arguments(overload, arguments, slots);
        if (refused) continue;
        if (run_machine_code(entry, overload, slots, &result)) return NULL;
        if (entry->result == 'b') return PyBool_FromLong(result != 0);
        if (entry->result == 'i') return PyLong_FromLongLong(result);
        Py_RETURN_NONE;
    }
    if (refused) {
        PyErr_Format(PyExc_TypeError, "%s: argument %d, of %R, does not match the compiled type: other type, number of axes or "
                     "array flags", entry->name, -refused, Py_TYPE(arguments[-1 - refused]));
    } else {
        PyErr_Format(PyExc_TypeError, "%s: %zd arguments; it was compiled for another number", entry->name, n_arguments);
    }
    return NULL;
}

/* ---- creation ---- */

static int type_of_code(char code) {
    switch (code) {
    case 'd': return NPY_DOUBLE;
    case 'i': return NPY_INT64;
    case 'b': return NPY_BOOL;
    case 'h': return NPY_INT32;
    case 'f': return NPY_FLOAT;
    case 'u': return NPY_UINT8;
    case '[': return NPY_VOID;
    default: return -1;
    }
}

/* Reads the class and the size of records, such as "SearchState 168]"; returns the rest of the text, or NULL. */
static const char *read_record(const char *text, Kind *kind) {
    int used = 0;
    if (sscanf(text, "%47[^] ] %d]%n", kind->record, &kind->size, &used) != 2 || !used) return NULL;
    return text + used;
}

/* Reads one argument of a signature (src/ulna/engine/signatures.py); returns the rest of the text, or NULL. */
static const char *read_kind(const char *text, Overload *overload, int within) {
    if (overload->n_kinds == MAX_KINDS) return NULL;
    Kind *kind = &overload->kinds[overload->n_kinds++];
    kind->what = *text;
    if (*text == 'i' || *text == 'd' || *text == '-') return text + 1;
    if (*text >= '0' && *text <= '9') {
        kind->what = 'a';
        kind->dimensions = *text - '0';
        if (text[1] != 'r' && text[1] != 'w') return NULL;
        kind->constant = text[1] == 'r';
        kind->type = type_of_code(text[2]);
        if (kind->type == NPY_VOID) return read_record(text + 3, kind);
        return kind->type < 0 ? NULL : text + 3;
    }
    if (*text != '(' || within) return NULL;
    for (text++; text && *text != ')'; kind->dimensions++) text = read_kind(text, overload, 1);
    return text ? text + 1 : NULL;
}

static int read_signature(const char *text, Overload *overload) {
    int slots = 0;
    for (; text && *text; overload->n_arguments++) text = read_kind(text, overload, 0);
    for (int k = 0; k < overload->n_kinds; k++) slots += 1 + (overload->kinds[k].what == 'a' ? overload->kinds[k].dimensions : 0);
    if (text && slots <= MAX_SLOTS) return 0;
    PyErr_SetString(PyExc_ValueError, "invalid signature");
    return -1;
}

static int read_overloads(Entry *entry, PyObject *overloads) {
    Py_ssize_t n = PyTuple_Size(overloads);
    entry->overloads = PyMem_Calloc(n ? n : 1, sizeof(Overload));
    if (!entry->overloads) return PyErr_NoMemory(), -1;
    for (entry->n_overloads = 0; entry->n_overloads < n; entry->n_overloads++) {
        Overload *overload = &entry->overloads[entry->n_overloads];
        unsigned long long address;
        const char *signature;
        PyObject *pair = PyTuple_GetItem(overloads, entry->n_overloads);
        if (!PyTuple_Check(pair)) return PyErr_SetString(PyExc_TypeError, "pairs of an address and a signature are expected"), -1;
        if (!PyArg_ParseTuple(pair, "Ks", &address, &signature)) return -1;
        if (!address) return PyErr_SetString(PyExc_ValueError, "invalid address 0"), -1;
        overload->function = (Function)(uintptr_t)address;
        if (read_signature(signature, overload)) return -1;
    }
    return 0;
}

PyObject *make_entry(PyObject *module, PyObject *arguments) {
    const char *name, *result;
    PyObject *overloads, *function = NULL;
    int releases_lock;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "sO!sp", &name, &PyTuple_Type, &overloads, &result, &releases_lock)) return NULL;
    if (!*result || !strchr("bi-", *result)) return PyErr_SetString(PyExc_ValueError, "invalid result type: b, i or - is expected"), NULL;
    Entry *entry = PyObject_New(Entry, entry_type);
    if (!entry) return NULL;
    entry->overloads = NULL;
    entry->result = *result;
    entry->releases_lock = releases_lock;
    entry->name = PyMem_Malloc(strlen(name) + 1);
    if (!entry->name) {
        PyErr_NoMemory();
    } else if (strcpy(entry->name, name), !read_overloads(entry, overloads)) {
        PyMethodDef method = {entry->name, (PyCFunction)(void (*)(void))call_entry, METH_FASTCALL, NULL};
        entry->method = method;
        function = PyCFunction_NewEx(&entry->method, (PyObject *)entry, NULL);
    }
    Py_DECREF(entry);
    return function;
}

static void free_entry(PyObject *self) {
    PyTypeObject *type = Py_TYPE(self);
    PyMem_Free(((Entry *)self)->overloads);
    PyMem_Free(((Entry *)self)->name);
    PyObject_Free(self);
    Py_DECREF(type);
}

static PyType_Slot slots_of_type[] = {{Py_tp_dealloc, free_entry}, {0, NULL}};
PyType_Spec entry_spec = {"ulna.engine._calls.Entry", sizeof(Entry), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots_of_type};
