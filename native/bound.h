/* Functions of one configuration, or of one target, whose other arguments are bound. */
#ifndef ULNA_BOUND_H
#define ULNA_BOUND_H
#include "entry.h"

/* Of a scene, the rows of the objects that are not in the BVH (kernels/collision/scene.py): first and end. They are the last slots but
   the three of may_touch. */
typedef int64_t Span[2];
enum { SPAN_TO_END = 5 };

#define MOST_SCRATCH 16 /* numbers that a record of the way NUMBER may be as long as, and branches that BRANCHES has */

typedef PyObject *(*Call)(PyObject *, PyObject *const *, Py_ssize_t, PyObject *);

/* What a bound function takes and returns (ways.c). */
typedef struct {
    const char *name;
    Call call;
    const char *rest; /* what follows the leading arguments: arrays of float64, by their number of axes; 't': truths, 2 axes;
                         'i': whole numbers, 1 axis; 'r': records like those given; 'd': a number */
    char result;
    int n_numbers;
} Way;

typedef struct {
    PyObject_HEAD
    PyMethodDef method;
    const Way *way;
    Entry *entry;
    const Overload *overload;
    PyObject *leading;   /* what the slots point into */
    PyObject *otherwise;
    PyObject *like;      /* an array of the records that the entry writes, or None */
    int n_slots;
    npy_intp n;          /* entries of q */
    npy_intp numbers[2];
    int64_t slots[MOST_SLOTS];
} Bound;

extern PyType_Spec bound_spec;
extern PyTypeObject *bound_type;
extern const Way POSE, TRUTH, NUMBER, SEARCH, BRANCHES, COPY, EDGE;

/* bind(entry, way, leading, n, numbers, otherwise, like=None): see bound.c. */
PyObject *bind_entry(PyObject *module, PyObject *arguments);
/* What a function that bind made is bound to, or NULL if it is another function, or of another way. */
Bound *bound_of(PyObject *function, const Way *way);
const Way *way_of(const char *name);

/* What machine code returns. NULL without an exception: an argument is not as it should be, or was refused, so Python must be asked. */
PyObject *pose_of(Bound *bound, PyObject *q, PyObject *out);
/* In the scene that is bound, or with other rows of its table, unless ``span`` is NULL. */
PyObject *truth_of(Bound *bound, PyObject *q, const int64_t *span);
PyObject *number_of(Bound *bound, PyObject *q, const int64_t *span);
/* Whether the edge touches, how far it is free and a new array, q there; -1, with or without an exception: as with NULL above. */
int edge_of(Bound *bound, PyObject *q_a, PyObject *q_b, double resolution, const int64_t *span, double *free_until, PyObject **q);
/* 1 and two new arrays, 0 if there is no solution, -1 with an exception, -2 if Python must be asked. */
int search_of(Bound *bound, PyObject *target, PyObject *seed, PyObject **q, PyObject **info);
/* What is proved, and three new arrays that cannot be written to; -1, with or without an exception: as with NULL above. */
int branches_of(Bound *bound, PyObject *target, PyObject **q, PyObject **valid, PyObject **real);

/* Calls a callable with the arguments as they were, ``first`` before them unless it is NULL. */
PyObject *call_with(PyObject *function, PyObject *first, PyObject *const *arguments, Py_ssize_t n, PyObject *names);

#endif
