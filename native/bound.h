/* Functions of one configuration, or of one target, whose other arguments are bound. */
#ifndef ULNA_BOUND_H
#define ULNA_BOUND_H
#include "entry.h"

extern PyType_Spec bound_spec;
extern PyTypeObject *bound_type;

/* bind(entry, way, leading, n, numbers, otherwise): see bound.c. */
PyObject *bind(PyObject *module, PyObject *arguments);

#endif
