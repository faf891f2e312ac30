/* The module ulna.engine._calls: machine code as functions that Python calls. */
#define ULNA_IMPORTS_NUMPY
#include "entry.h"
#include "bases.h"
#include "cpu.h"
#include "method.h"

static PyObject *level_of_cpu(PyObject *module, PyObject *unused) {
    (void)module, (void)unused;
    return PyLong_FromLong(x86_level());
}

static PyMethodDef methods[] = {
    {"make_entry", make_entry, METH_VARARGS, "make_entry(name, ((address, signature), ...), result, releases_lock)"},
    {"bind", bind_entry, METH_VARARGS, "bind(entry, way, leading, n, numbers, otherwise): a function of one q, or of one target"},
    {"make_method", make_method, METH_VARARGS, "make_method(class, name, function, text): a method in C for a function of the class"},
    {"x86_level", level_of_cpu, METH_NOARGS, "The highest level of x86-64 that this processor has, 1 to 4; 0 for another processor."},
    {NULL, NULL, 0, NULL},
};
static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, "_calls", NULL, -1, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__calls(void) {
    import_array();
    entry_type = (PyTypeObject *)PyType_FromSpec(&entry_spec);
    bound_type = (PyTypeObject *)PyType_FromSpec(&bound_spec);
    quick_type = (PyTypeObject *)PyType_FromSpec(&quick_spec);
    seen_type = (PyTypeObject *)PyType_FromSpec(&seen_spec);
    PyObject *called = PyType_FromSpec(&called_spec), *module = PyModule_Create(&definition);
    if (!entry_type || !bound_type || !quick_type || !seen_type || !called || !module || make_names()) return NULL;
    if (PyModule_AddObjectRef(module, "Entry", (PyObject *)entry_type) || PyModule_AddObjectRef(module, "Called", called) ||
        PyModule_AddObjectRef(module, "Quick", (PyObject *)quick_type) || PyModule_AddObjectRef(module, "Seen", (PyObject *)seen_type)) {
        return NULL;
    }
    return module;
}
