/* Classes that Python's own inherit: what their methods in C read has a place in the structure, and is not looked up by name. */
#ifndef ULNA_BASES_H
#define ULNA_BASES_H
#include "bound.h"

/* Of a robot: the tables of its prebound entries, which ``keep_prebound`` sets in this order (engine/bound.py, Quick). */
enum { FORWARDS, JACOBIANS, SCENE, SEARCHES, BRANCHED, N_TABLES };

typedef struct {
    PyObject_HEAD
    PyObject *tables[N_TABLES];
    Bound *forward, *jacobian; /* what the functions of the tip are bound to, NULL until the methods have found it (method.c) */
} Quick;

/* Of a function of q, and of a world: one object, which Python reads and sets as ``in_c`` and as ``_objects``; NULL is None. */
typedef struct {
    PyObject_HEAD
    PyObject *kept;
} Keeping;

extern PyType_Spec quick_spec, called_spec, seen_spec;
extern PyTypeObject *quick_type, *seen_type;

#endif
