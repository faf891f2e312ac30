/* The module ulna.engine._calls: machine code as functions that Python calls. */
#define ULNA_IMPORTS_NUMPY
#include "entry.h"
#include "bound.h"
#include "cpu.h"

static PyObject *level_of_cpu(PyObject *module, PyObject *unused) {
    (void)module, (void)unused;
    return PyLong_FromLong(x86_level());
}

static PyMethodDef methods[] = {
    {"make_entry", make_entry, METH_VARARGS, "make_entry(name, ((address, signature), ...), result, releases_lock)"},
    {"x86_level", level_of_cpu, METH_NOARGS, "The highest level of x86-64 that this processor has, 1 to 4; 0 for another processor."},
    {NULL, NULL, 0, NULL},
};
static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, "_calls", NULL, -1, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__calls(void) {
    import_array();
    entry_type = (PyTypeObject *)PyType_FromSpec(&entry_spec);
    PyObject *bound = PyType_FromSpec(&bound_spec), *module = PyModule_Create(&definition);
    if (!entry_type || !bound || !module) return NULL;
    if (PyModule_AddObjectRef(module, "Entry", (PyObject *)entry_type) || PyModule_AddObjectRef(module, "Bound", bound)) return NULL;
    return module;
}
