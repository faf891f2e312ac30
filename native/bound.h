/* Functions of one configuration, or of one target, with bound leading arguments. */
#ifndef ULNA_BOUND_H
#define ULNA_BOUND_H
#include "entry.h"

/* The rows of a scene's objects outside the BVH (kernels/collision/scene.py), first and end: the last slots before the three of
   may_touch. */
enum { ROWS_TO_END = 5 };

#define MAX_SCRATCH 16 /* maximum length of NUMBER's record in numbers, and of BRANCHES in branches */

#define MAX_ARGUMENTS 5 /* of a bound function's call */

typedef struct Bound Bound;
/* Calls machine code. NULL without an exception: an argument is unsuitable or was refused, so Python must process it. */
typedef PyObject *(*Call)(Bound *, PyObject *const *, Py_ssize_t);

/* The arguments and the result of a bound function (ways.c). */
typedef struct {
    const char *name;
    Call call;
    const char *rest; /* the arguments after the leading ones: arrays of float64, by their number of axes; 't': bools, 2 axes;
                         'i': integers, 1 axis; 'r': records like the given ones; 'd': a number */
    char result;
    int n_numbers;
    int takes_out; /* accepts ``out`` as second or named argument */
} Way;

struct Bound {
    PyObject_HEAD
    const Way *way;
    Entry *entry;        /* NULL: Python processes every call */
    const Overload *overload;
    PyObject *leading;   /* the slots point into them */
    PyObject *otherwise;
    PyObject *like;      /* an array of the records that the entry writes, or None */
    int n_slots;
    npy_intp n;          /* entries of q */
    npy_intp numbers[2];
    int64_t slots[MAX_SLOTS];
};

extern PyType_Spec bound_spec;
extern const Way TRUTH, NUMBER, EDGE, BRANCHES;
const Way *way_of(const char *name);

#endif
