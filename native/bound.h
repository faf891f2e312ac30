/* Functions of one configuration, or of one target, whose other arguments are bound. */
#ifndef ULNA_BOUND_H
#define ULNA_BOUND_H
#include "entry.h"

/* Of a scene, the rows of the objects that are not in the BVH (kernels/collision/scene.py): first and end. They are the last slots but
   the three of may_touch. */
enum { ROWS_TO_END = 5 };

#define MOST_SCRATCH 16 /* numbers that a record of the way NUMBER may be as long as, and branches that BRANCHES has */

#define MOST_ARGUMENTS 5 /* of a bound function */

typedef struct Bound Bound;
/* Calls machine code. NULL without an exception: an argument is not as it should be, or was refused, so Python must be asked. */
typedef PyObject *(*Call)(Bound *, PyObject *const *, Py_ssize_t);

/* What a bound function takes and returns (ways.c). */
typedef struct {
    const char *name;
    Call call;
    const char *rest; /* what follows the leading arguments: arrays of float64, by their number of axes; 't': truths, 2 axes;
                         'i': whole numbers, 1 axis; 'r': records like those given; 'd': a number */
    char result;
    int n_numbers;
    int takes_out; /* as its second argument, also by name */
} Way;

struct Bound {
    PyObject_HEAD
    const Way *way;
    Entry *entry;        /* NULL: Python is always asked */
    const Overload *overload;
    PyObject *leading;   /* what the slots point into */
    PyObject *otherwise;
    PyObject *like;      /* an array of the records that the entry writes, or None */
    int n_slots;
    npy_intp n;          /* entries of q */
    npy_intp numbers[2];
    int64_t slots[MOST_SLOTS];
};

extern PyType_Spec bound_spec;
extern const Way TRUTH, NUMBER, EDGE, BRANCHES;
const Way *way_of(const char *name);

#endif
