/* Classes that Python's own inherit, so that what a call needs is found without a look-up by name. */
#ifndef ULNA_BASES_H
#define ULNA_BASES_H
#include "bound.h"

/* Of a robot: what the functions of the tip are bound to, NULL until the methods have found it (method.c). */
typedef struct {
    PyObject_HEAD
    Bound *forward, *jacobian;
} Quick;

extern PyType_Spec quick_spec, called_spec;
extern PyTypeObject *quick_type;

#endif
