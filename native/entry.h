/* What entry.c gives to the other files: an entry, its arguments as slots, and the call of its machine code. */
#ifndef ULNA_ENTRY_H
#define ULNA_ENTRY_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdint.h>
#define NPY_NO_DEPRECATED_API NPY_1_20_API_VERSION
#define PY_ARRAY_UNIQUE_SYMBOL ulna_numpy
#ifndef ULNA_IMPORTS_NUMPY
#define NO_IMPORT_ARRAY
#endif
#include <numpy/arrayobject.h>

#define MOST_SLOTS 96
#define MOST_KINDS 48
#define MOST_NAME 48

/* Machine code as src/ulna/engine/emit.py wraps it: slots of 8 bytes in, one slot out. Nonzero: it could not get memory. */
typedef int32_t (*Function)(const int64_t *slots, int64_t *result);

/* One argument: 'i' a whole number, 'd' a number, '-' None, 'a' an array, '(' a tuple, whose parts are the kinds that follow. */
typedef struct {
    char what;
    int dimensions; /* of an array; the parts of a tuple */
    int type;       /* NumPy's number of the elements' type */
    int constant;   /* only read, so that it may be read-only */
    char record[MOST_NAME]; /* of an array of records: the name of their class (src/ulna/engine/records.py), else empty */
    int size;       /* and their size in bytes */
} Kind;

typedef struct {
    Function function;
    int n_kinds, n_arguments;
    Kind kinds[MOST_KINDS];
} Overload;

typedef struct {
    PyObject_HEAD
    PyMethodDef method; /* of the function that Python calls, whose self this is */
    char *name;
    char result;        /* 'b' True or False, 'i' a whole number, '-' None */
    int releases_lock;
    int n_overloads;
    Overload *overloads;
} Entry;

extern PyType_Spec entry_spec;
extern PyTypeObject *entry_type;

/* make_entry(name, ((address, signature), ...), result, releases_lock): the function that Python calls. */
PyObject *make_entry(PyObject *module, PyObject *arguments);
/* The slots of an argument: how many, or -1 if it has another type (no exception is set). */
int take_argument(const Kind *kind, PyObject *argument, int64_t *slots);
/* How many kinds an argument is: 1, or a tuple and its parts. */
int kinds_of(const Kind *kind);
/* Runs machine code: 0, or -1 with a MemoryError. */
int run_machine_code(const Entry *entry, const Overload *overload, const int64_t *slots, int64_t *result);

#endif
