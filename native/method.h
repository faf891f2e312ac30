/* Methods of a robot in C, for one configuration or one target. */
#ifndef ULNA_METHOD_H
#define ULNA_METHOD_H
#include "entry.h"

int make_names(void);
/* method(class, name, function, text): see method.c. */
PyObject *make_method(PyObject *module, PyObject *arguments);

#endif
