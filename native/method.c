/* Partial application of entries: seven methods of Robot in C. Each looks up the prebound entry for its arguments and calls it.

Where there is none yet, or the arguments are others than a control loop passes, the method of the same name in Python is called: it
binds the entry for the next time. A robot's prebound entries are in its five tables (bases.h; engine/bound.py, Quick):

    forward_kinematics(q, *, link=None, out=None)           FORWARDS[link]; that of the tip is kept
    jacobian(q, *, link=None, out=None)                     JACOBIANS[link]; the same
    in_collision(q, world=None, *, self_collision=True)     SCENE[0], a tuple: the objects, self_collision, and for both methods
    signed_distance(q, world=None, *, self_collision=True)  an entry; the objects are those of ``Seen``, or None without a
    edge_in_collision(q_a, q_b, world=None, *,              world; with others of the same layout the rows are put in place;
                      self_collision=True)                  of edges a tuple: the entry, the class of the result, a resolution
    inverse_kinematics(T, q_seed=None, *, link=None)        SEARCHES[link]: see below
    all_solutions(T, *, link=None)                          BRANCHED[link]: see below
*/
#include "method.h"

#include <string.h>

#include "bases.h"

enum { FORWARD, JACOBIAN, IN_COLLISION, DISTANCE, EDGES, INVERSE, SOLUTIONS, N_METHODS };

/* What SCENE[0] has; behind the first two what each of the methods is bound to. */
enum { OBJECTS_OF_SCENE, ITSELF_OF_SCENE, TOUCHES_OF_SCENE, NEAREST_OF_SCENE, EDGE_OF_SCENE, N_PARTS_OF_SCENE };

static PyObject *in_python[N_METHODS]; /* the methods of the same name in Python */

/* Names of arguments and of the fields of a result, interned. */
static PyObject *OUT, *LINK, *SEED, *WORLD, *ITSELF, *Q, *INFO, *VALID, *REAL, *PROOF, *OBJECTS, *LAYOUT, *FIRST, *END, *TOUCHES, *FREE_UNTIL;

int make_names(void) {
    const struct { PyObject **place; const char *name; } all[] = {
        {&OUT, "out"}, {&LINK, "link"}, {&SEED, "q_seed"}, {&WORLD, "world"}, {&ITSELF, "self_collision"},
        {&Q, "q"}, {&INFO, "info"}, {&VALID, "valid"}, {&REAL, "real"}, {&PROOF, "proof"},
        {&OBJECTS, "objects"}, {&LAYOUT, "layout"}, {&FIRST, "first"}, {&END, "end"},
        {&TOUCHES, "in_collision"}, {&FREE_UNTIL, "free_until"},
    };
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        if (!(*all[k].place = PyUnicode_InternFromString(all[k].name))) return -1;
    }
    return 0;
}

/* What a table of a robot has for a key, a new reference, or NULL without an exception. */
static PyObject *entry_of(PyObject *self, int table, PyObject *key) {
    PyObject *entries = ((Quick *)self)->tables[table], *found = entries ? PyDict_GetItemWithError(entries, key) : NULL;
    if (!found) PyErr_Clear();
    return Py_XNewRef(found);
}

/* An object of a class whose fields are those given (none if NULL), and some new ones: n names, each with its value. */
static PyObject *made(PyObject *class, PyObject *fields, int n, PyObject *const *names, PyObject *const *values) {
    PyObject *object = PyType_GenericAlloc((PyTypeObject *)class, 0), *name, *value;
    for (int k = 0; object && k < n; k++) {
        if (PyObject_GenericSetAttr(object, names[k], values[k])) Py_CLEAR(object);
    }
    for (Py_ssize_t place = 0; object && fields && PyDict_Next(fields, &place, &name, &value);) {
        if (PyObject_GenericSetAttr(object, name, value)) Py_CLEAR(object);
    }
    return object;
}

/* What the function of a link is bound to, a new reference, or NULL without an exception. That of the tip is kept at ``place``. */
static Bound *of_link(PyObject *self, Bound **place, int part, PyObject *link) {
    if (link == Py_None && *place) return (Bound *)Py_NewRef((PyObject *)*place);
    PyObject *function = entry_of(self, part, link);
    Bound *bound = function ? bound_of(function, &POSE) : NULL;
    Py_XINCREF((PyObject *)bound);
    Py_XDECREF(function);
    if (bound && link == Py_None) *place = (Bound *)Py_NewRef((PyObject *)bound);
    return bound;
}

static PyObject *by_link(
    int which, Bound **place, int part, PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names
) {
    PyObject *link = Py_None, *out = Py_None, *result = NULL;
    Py_ssize_t n_names = names ? PyTuple_Size(names) : 0;
    int plain = n == 1;
    for (Py_ssize_t k = 0; k < n_names && plain; k++) {
        PyObject *name = PyTuple_GetItem(names, k);
        if (name == OUT) out = arguments[n + k];
        else if (name == LINK) link = arguments[n + k];
        else plain = 0;
    }
    Bound *bound = plain ? of_link(self, place, part, link) : NULL;
    if (bound) result = pose_of(bound, arguments[0], out == Py_None ? NULL : out);
    Py_XDECREF((PyObject *)bound);
    if (result || PyErr_Occurred()) return result;
    return call_with(in_python[which], self, arguments, n, names);
}

static PyObject *forward_kinematics(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    return by_link(FORWARD, &((Quick *)self)->forward, FORWARDS, self, arguments, n, names);
}

static PyObject *jacobian(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    return by_link(JACOBIAN, &((Quick *)self)->jacobian, JACOBIANS, self, arguments, n, names);
}

/* The objects of a world, a new reference; NULL if it is no world, or with an exception. They are laid out if they have changed. */
static PyObject *objects_of(PyObject *world) {
    if (world == Py_None) return Py_NewRef(Py_None);
    if (!PyObject_TypeCheck(world, seen_type)) return NULL;
    PyObject *kept = ((Keeping *)world)->kept;
    if (kept && kept != Py_None) return Py_NewRef(kept);
    return PyObject_CallMethodObjArgs(world, OBJECTS, NULL);
}

/* Reads where the rows of objects are in the layout that others have too; 0 if it is another. No exception is set. */
static int read_span(PyObject *objects, PyObject *others, int64_t *span) {
    PyObject *parts[4] = {PyObject_GetAttr(objects, LAYOUT), NULL, NULL, NULL};
    if (parts[0]) parts[1] = PyObject_GetAttr(others, LAYOUT);
    int same = parts[1] && parts[0] == parts[1];
    if (same) {
        parts[2] = PyObject_GetAttr(objects, FIRST);
        parts[3] = PyObject_GetAttr(objects, END);
        for (int k = 0; k < 2; k++) span[k] = parts[2 + k] ? PyLong_AsLongLong(parts[2 + k]) : -1;
        same = !PyErr_Occurred();
    }
    PyErr_Clear();
    for (int k = 0; k < 4; k++) Py_XDECREF(parts[k]);
    return same;
}

/* The prebound entry of a collision query about objects, a new reference, or NULL without an exception. Where objects have moved since
   it was bound, its scene is theirs but for its rows, which are written to ``span``; otherwise *moved is 0. */
static PyObject *of_scene(int place, PyObject *self, PyObject *objects, PyObject *itself, int64_t *span, int *moved) {
    PyObject *list = ((Quick *)self)->tables[SCENE], *scene = NULL, *function = NULL;
    if (list && PyList_Size(list) == 1) scene = Py_NewRef(PyList_GetItem(list, 0));
    if (scene && PyTuple_Check(scene) && PyTuple_Size(scene) == N_PARTS_OF_SCENE && itself == PyTuple_GetItem(scene, ITSELF_OF_SCENE)) {
        PyObject *bound_to = PyTuple_GetItem(scene, OBJECTS_OF_SCENE);
        *moved = objects != bound_to;
        if (!*moved || read_span(objects, bound_to, span)) {
            function = Py_NewRef(PyTuple_GetItem(scene, place));
        }
    }
    Py_XDECREF(scene);
    return function;
}

/* Reads the arguments of a query whose first n_q are configurations: then a world, and by name that or self_collision. 0 if there
   are others, which Python reads. */
static int read_query(int n_q, PyObject *const *arguments, Py_ssize_t n, PyObject *names, PyObject **world, PyObject **itself) {
    Py_ssize_t n_names = names ? PyTuple_Size(names) : 0;
    if (n != n_q && n != n_q + 1) return 0;
    *world = n > n_q ? arguments[n_q] : Py_None;
    *itself = Py_True;
    for (Py_ssize_t k = 0; k < n_names; k++) {
        PyObject *name = PyTuple_GetItem(names, k);
        if (name == WORLD && n == n_q) *world = arguments[n + k];
        else if (name == ITSELF) *itself = arguments[n + k];
        else return 0;
    }
    return 1;
}

static PyObject *about_collision(int which, PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    PyObject *world, *itself, *result = NULL;
    int moved = 0, place = which == DISTANCE ? NEAREST_OF_SCENE : TOUCHES_OF_SCENE;
    Span span;
    PyObject *objects = read_query(1, arguments, n, names, &world, &itself) ? objects_of(world) : NULL;
    PyObject *function = objects ? of_scene(place, self, objects, itself, span, &moved) : NULL;
    Bound *bound = function ? bound_of(function, which == DISTANCE ? &NUMBER : &TRUTH) : NULL;
    if (bound) result = (which == DISTANCE ? number_of : truth_of)(bound, arguments[0], moved ? span : NULL);
    Py_XDECREF(function);
    Py_XDECREF(objects);
    if (result || PyErr_Occurred()) return result;
    return call_with(in_python[which], self, arguments, n, names);
}

/* The report of an edge; NULL without an exception if Python must be asked. ``parts``: the entry, the class, the resolution. */
static PyObject *report_of(PyObject *parts, PyObject *q_a, PyObject *q_b, const int64_t *span) {
    PyObject *q, *result = NULL;
    double free_until;
    Bound *bound = PyTuple_Check(parts) && PyTuple_Size(parts) == 3 ? bound_of(PyTuple_GetItem(parts, 0), &EDGE) : NULL;
    double resolution = bound ? PyFloat_AsDouble(PyTuple_GetItem(parts, 2)) : 0.0;
    int touches = bound ? edge_of(bound, q_a, q_b, resolution, span, &free_until, &q) : -1;
    if (touches < 0) return NULL;
    PyObject *fraction = PyFloat_FromDouble(free_until);
    if (fraction) {
        result = made(PyTuple_GetItem(parts, 1), NULL, 3, (PyObject *[]){TOUCHES, FREE_UNTIL, Q},
                      (PyObject *[]){touches ? Py_True : Py_False, fraction, q});
    }
    Py_XDECREF(fraction);
    Py_DECREF(q);
    return result;
}

static PyObject *edge_in_collision(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    PyObject *world, *itself, *result = NULL;
    int moved = 0;
    Span span;
    PyObject *objects = read_query(2, arguments, n, names, &world, &itself) ? objects_of(world) : NULL;
    PyObject *parts = objects ? of_scene(EDGE_OF_SCENE, self, objects, itself, span, &moved) : NULL;
    if (parts) result = report_of(parts, arguments[0], arguments[1], moved ? span : NULL);
    Py_XDECREF(parts);
    Py_XDECREF(objects);
    if (result || PyErr_Occurred()) return result;
    return call_with(in_python[EDGES], self, arguments, n, names);
}

static PyObject *in_collision(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    return about_collision(IN_COLLISION, self, arguments, n, names);
}

static PyObject *signed_distance(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    return about_collision(DISTANCE, self, arguments, n, names);
}

/* ---- inverse kinematics ----
SEARCHES[link] is a tuple of: the search from home, home, the search from a seed, the class of the result, its fields but q and
info, and what is called with both arguments where neither search finds a solution. */

enum { FROM_HOME, HOME, FROM_SEED, RESULT, FIELDS, OTHERWISE, N_PARTS };

static PyObject *inverse_kinematics(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    PyObject *seed = n > 1 ? arguments[1] : Py_None, *link = Py_None;
    Py_ssize_t n_names = names ? PyTuple_Size(names) : 0;
    int plain = n == 1 || n == 2;
    for (Py_ssize_t k = 0; k < n_names && plain; k++) {
        PyObject *name = PyTuple_GetItem(names, k);
        if (name == SEED && n < 2) seed = arguments[n + k];
        else if (name == LINK) link = arguments[n + k];
        else plain = 0;
    }
    PyObject *search = plain ? entry_of(self, SEARCHES, link) : NULL;
    PyObject *parts[N_PARTS], *q = NULL, *info = NULL, *result = NULL;
    int found = -2, from_home = seed == Py_None;
    if (search && PyTuple_Size(search) == N_PARTS) {
        for (int k = 0; k < N_PARTS; k++) parts[k] = PyTuple_GetItem(search, k);
        PyObject *function = parts[from_home ? FROM_HOME : FROM_SEED];
        Bound *bound = bound_of(function, &SEARCH);
        if (bound) found = search_of(bound, arguments[0], from_home ? parts[HOME] : seed, &q, &info);
    }
    if (found == 1) result = made(parts[RESULT], parts[FIELDS], 2, (PyObject *[]){Q, INFO}, (PyObject *[]){q, info});
    if (found == 0) result = PyObject_CallFunctionObjArgs(parts[OTHERWISE], arguments[0], seed, NULL);
    if (found == -2) result = call_with(in_python[INVERSE], self, arguments, n, names);
    Py_XDECREF(q);
    Py_XDECREF(info);
    Py_XDECREF(search);
    return result;
}

/* ---- all solutions ----
BRANCHED[link] is a tuple of: the branches of a target, the class of the result, what is proved by code, the family as a field. */

enum { BRANCHES_OF, SOLUTIONS_CLASS, PROOFS, FAMILY, N_PARTS_OF_SOLUTIONS };

static PyObject *solutions_of(PyObject *parts, PyObject *target) {
    PyObject *q, *valid, *real, *result = NULL;
    Bound *bound = bound_of(PyTuple_GetItem(parts, BRANCHES_OF), &BRANCHES);
    int code = bound ? branches_of(bound, target, &q, &valid, &real) : -1;
    if (code < 0) return NULL;
    PyObject *proof = PyTuple_GetItem(PyTuple_GetItem(parts, PROOFS), code);
    if (proof) {
        result = made(PyTuple_GetItem(parts, SOLUTIONS_CLASS), PyTuple_GetItem(parts, FAMILY), 4,
                      (PyObject *[]){Q, VALID, REAL, PROOF}, (PyObject *[]){q, valid, real, proof});
    }
    Py_DECREF(q);
    Py_DECREF(valid);
    Py_DECREF(real);
    return result;
}

static PyObject *all_solutions(PyObject *self, PyObject *const *arguments, Py_ssize_t n, PyObject *names) {
    PyObject *link = Py_None, *result = NULL;
    Py_ssize_t n_names = names ? PyTuple_Size(names) : 0;
    int plain = n == 1 && n_names <= 1;
    if (plain && n_names) {
        plain = PyTuple_GetItem(names, 0) == LINK;
        link = arguments[1];
    }
    PyObject *parts = plain ? entry_of(self, BRANCHED, link) : NULL;
    if (parts && PyTuple_Size(parts) == N_PARTS_OF_SOLUTIONS) result = solutions_of(parts, arguments[0]);
    Py_XDECREF(parts);
    if (result || PyErr_Occurred()) return result;
    return call_with(in_python[SOLUTIONS], self, arguments, n, names);
}

/* ---- making one ---- */

static const struct { const char *name; Call call; } methods[N_METHODS] = {
    [FORWARD] = {"forward_kinematics", forward_kinematics},
    [JACOBIAN] = {"jacobian", jacobian},
    [IN_COLLISION] = {"in_collision", in_collision},
    [DISTANCE] = {"signed_distance", signed_distance},
    [EDGES] = {"edge_in_collision", edge_in_collision},
    [INVERSE] = {"inverse_kinematics", inverse_kinematics},
    [SOLUTIONS] = {"all_solutions", all_solutions},
};
static PyMethodDef definitions[N_METHODS];

static char *copied(const char *text) {
    char *copy = PyMem_Malloc(strlen(text) + 1);
    return copy ? strcpy(copy, text) : NULL;
}

/* A method for a class, which stands for a function: the same name, and its signature and its docstring as ``text`` has them. */
PyObject *make_method(PyObject *module, PyObject *arguments) {
    PyObject *class, *function;
    const char *name, *text;
    (void)module;
    if (!PyArg_ParseTuple(arguments, "O!sOs", &PyType_Type, &class, &name, &function, &text)) return NULL;
    if (!PyType_IsSubtype((PyTypeObject *)class, quick_type)) {
        return PyErr_SetString(PyExc_TypeError, "a class that inherits Quick is expected"), NULL;
    }
    for (int k = 0; k < N_METHODS; k++) {
        if (strcmp(methods[k].name, name)) continue;
        PyCFunction call = (PyCFunction)(void (*)(void))methods[k].call;
        PyMethodDef definition = {methods[k].name, call, METH_FASTCALL | METH_KEYWORDS, copied(text)};
        if (!definition.ml_doc) return PyErr_NoMemory();
        definitions[k] = definition;
        Py_XDECREF(in_python[k]);
        in_python[k] = Py_NewRef(function);
        return PyDescr_NewMethod((PyTypeObject *)class, &definitions[k]);
    }
    return PyErr_Format(PyExc_ValueError, "there is no method %s", name);
}
