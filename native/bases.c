/* Classes that Python's own inherit:

    Quick    of a robot: has room for what the two functions that are called most are bound to.
    Called   of a function of q: ``in_c``, a bound function or None; a call of the object is a call of it, or of ``self._validated``.
*/
#include "bases.h"

#include <stddef.h>

PyTypeObject *quick_type;

static void free_object(PyObject *self, int (*clear)(PyObject *)) {
    PyTypeObject *type = Py_TYPE(self);
    PyObject_GC_UnTrack(self);
    clear(self);
    ((freefunc)PyType_GetSlot(type, Py_tp_free))(self);
    Py_DECREF(type);
}

/* ---- Quick ---- */

static int visit_quick(PyObject *self, visitproc visit, void *arg) {
    Py_VISIT(Py_TYPE(self));
    Py_VISIT(((Quick *)self)->forward);
    Py_VISIT(((Quick *)self)->jacobian);
    return 0;
}

static int clear_quick(PyObject *self) {
    Py_CLEAR(((Quick *)self)->forward);
    Py_CLEAR(((Quick *)self)->jacobian);
    return 0;
}

static void free_quick(PyObject *self) { free_object(self, clear_quick); }

static PyType_Slot slots_of_quick[] = {
    {Py_tp_dealloc, free_quick}, {Py_tp_traverse, visit_quick}, {Py_tp_clear, clear_quick}, {0, NULL}};
PyType_Spec quick_spec = {"ulna.engine._calls.Quick", sizeof(Quick), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_BASETYPE,
                          slots_of_quick};

/* ---- Called ---- */

typedef struct {
    PyObject_HEAD
    PyObject *in_c;
} Called;

static PyObject *call(PyObject *self, PyObject *arguments, PyObject *named) {
    PyObject *function = ((Called *)self)->in_c, *out = NULL, *result = NULL;
    Bound *bound = function ? bound_of(function, &POSE) : NULL;
    Py_ssize_t n = PyTuple_Size(arguments);
    int plain = bound && n >= 1 && (n < 3 || (n == 3 && PyTuple_GetItem(arguments, 2) == Py_None)); /* threads: Python checks them */
    if (plain && n > 1) out = PyTuple_GetItem(arguments, 1);
    if (plain && named) {
        out = n == 1 && PyDict_Size(named) == 1 ? PyDict_GetItemString(named, "out") : NULL;
        plain = out != NULL;
    }
    if (plain) result = pose_of(bound, PyTuple_GetItem(arguments, 0), out == Py_None ? NULL : out);
    if (result || PyErr_Occurred()) return result;
    PyObject *validated = PyObject_GetAttrString(self, "_validated");
    if (validated) result = PyObject_Call(validated, arguments, named);
    Py_XDECREF(validated);
    return result;
}

static int visit_called(PyObject *self, visitproc visit, void *arg) {
    Py_VISIT(Py_TYPE(self));
    Py_VISIT(((Called *)self)->in_c);
    return 0;
}

static int clear_called(PyObject *self) {
    Py_CLEAR(((Called *)self)->in_c);
    return 0;
}

static void free_called(PyObject *self) { free_object(self, clear_called); }

static PyObject *get_in_c(PyObject *self, void *unused) {
    (void)unused;
    PyObject *function = ((Called *)self)->in_c;
    return Py_NewRef(function ? function : Py_None);
}

static int set_in_c(PyObject *self, PyObject *function, void *unused) {
    (void)unused;
    PyObject *before = ((Called *)self)->in_c;
    ((Called *)self)->in_c = Py_XNewRef(function);
    Py_XDECREF(before);
    return 0;
}

static PyGetSetDef members_of_called[] = {{"in_c", get_in_c, set_in_c, "A bound function, or None.", NULL}, {NULL}};
static PyType_Slot slots_of_called[] = {{Py_tp_dealloc, free_called}, {Py_tp_traverse, visit_called}, {Py_tp_clear, clear_called},
                                        {Py_tp_call, call},           {Py_tp_getset, members_of_called}, {0, NULL}};
PyType_Spec called_spec = {"ulna.engine._calls.Called", sizeof(Called), 0,
                           Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_BASETYPE, slots_of_called};
