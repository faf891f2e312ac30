/* Classes that Python's own inherit:

    Quick    of a robot: the tables of its prebound entries, and room for what the two functions called most are bound to.
    Called   of a function of q: ``in_c``, a bound function or None; a call of the object is a call of it, or of ``self._validated``.
    Seen     of a world: ``_objects``, its objects as tables, None while they have changed (method.c then calls ``objects()``).
*/
#include "bases.h"

#include <structmember.h>

PyTypeObject *quick_type, *seen_type;

static void free_object(PyObject *self, int (*clear)(PyObject *)) {
    PyTypeObject *type = Py_TYPE(self);
    PyObject_GC_UnTrack(self);
    clear(self);
    ((freefunc)PyType_GetSlot(type, Py_tp_free))(self);
    Py_DECREF(type);
}

#define FLAGS (Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_BASETYPE)

/* ---- Quick ---- */

static int visit_quick(PyObject *self, visitproc visit, void *arg) {
    Py_VISIT(Py_TYPE(self));
    for (int k = 0; k < N_TABLES; k++) Py_VISIT(((Quick *)self)->tables[k]);
    Py_VISIT(((Quick *)self)->forward);
    Py_VISIT(((Quick *)self)->jacobian);
    return 0;
}

static int clear_quick(PyObject *self) {
    for (int k = 0; k < N_TABLES; k++) Py_CLEAR(((Quick *)self)->tables[k]);
    Py_CLEAR(((Quick *)self)->forward);
    Py_CLEAR(((Quick *)self)->jacobian);
    return 0;
}

static void free_quick(PyObject *self) { free_object(self, clear_quick); }

static PyObject *keep_prebound(PyObject *self, PyObject *tables) {
    PyObject *given[N_TABLES];
    if (!PyArg_ParseTuple(tables, "O!O!O!O!O!", &PyDict_Type, &given[FORWARDS], &PyDict_Type, &given[JACOBIANS], &PyList_Type,
                          &given[SCENE], &PyDict_Type, &given[SEARCHES], &PyDict_Type, &given[BRANCHED])) {
        return NULL;
    }
    clear_quick(self);
    for (int k = 0; k < N_TABLES; k++) ((Quick *)self)->tables[k] = Py_NewRef(given[k]);
    Py_RETURN_NONE;
}

static PyMethodDef methods_of_quick[] = {{"_keep_prebound", keep_prebound, METH_VARARGS, NULL}, {NULL, NULL, 0, NULL}};
static PyType_Slot slots_of_quick[] = {{Py_tp_dealloc, free_quick}, {Py_tp_traverse, visit_quick}, {Py_tp_clear, clear_quick},
                                       {Py_tp_methods, methods_of_quick}, {0, NULL}};
PyType_Spec quick_spec = {"ulna.engine._calls.Quick", sizeof(Quick), 0, FLAGS, slots_of_quick};

/* ---- Called, and Seen ---- */

static PyObject *call(PyObject *self, PyObject *arguments, PyObject *named) {
    PyObject *function = ((Keeping *)self)->kept, *out = NULL, *result = NULL;
    Bound *bound = function ? bound_of(function, &POSE) : NULL;
    Py_ssize_t n = PyTuple_Size(arguments);
    int plain = bound && (n == 1 || n == 2);
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

static int visit_keeping(PyObject *self, visitproc visit, void *arg) {
    Py_VISIT(Py_TYPE(self));
    Py_VISIT(((Keeping *)self)->kept);
    return 0;
}

static int clear_keeping(PyObject *self) {
    Py_CLEAR(((Keeping *)self)->kept);
    return 0;
}

static void free_keeping(PyObject *self) { free_object(self, clear_keeping); }

static PyMemberDef members_of_called[] = {{"in_c", T_OBJECT, offsetof(Keeping, kept), 0, NULL}, {NULL, 0, 0, 0, NULL}};
static PyMemberDef members_of_seen[] = {{"_objects", T_OBJECT, offsetof(Keeping, kept), 0, NULL}, {NULL, 0, 0, 0, NULL}};
static PyType_Slot slots_of_called[] = {{Py_tp_dealloc, free_keeping}, {Py_tp_traverse, visit_keeping}, {Py_tp_clear, clear_keeping},
                                        {Py_tp_call, call}, {Py_tp_members, members_of_called}, {0, NULL}};
static PyType_Slot slots_of_seen[] = {{Py_tp_dealloc, free_keeping}, {Py_tp_traverse, visit_keeping}, {Py_tp_clear, clear_keeping},
                                      {Py_tp_members, members_of_seen}, {0, NULL}};
PyType_Spec called_spec = {"ulna.engine._calls.Called", sizeof(Keeping), 0, FLAGS, slots_of_called};
PyType_Spec seen_spec = {"ulna.engine._calls.Seen", sizeof(Keeping), 0, FLAGS, slots_of_seen};
