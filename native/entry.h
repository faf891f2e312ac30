/* The interface of entry.c: an entry, its arguments as slots, and the call of its machine code. */
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

#define MAX_SLOTS 96
#define MAX_KINDS 48
#define MAX_NAME 48

/* Machine code as src/ulna/engine/emit.py wraps it: slots of 8 bytes in, one slot out. Nonzero: out of memory. */
typedef int32_t (*Function)(const int64_t *slots, int64_t *result);

/* One argument: 'i' an integer, 'd' a number, '-' None, 'a' an array, '(' a tuple, whose parts are the following kinds. */
typedef struct {
    char what;
    int dimensions; /* axes of an array; parts of a tuple */
    int type;       /* NumPy's type number of the elements */
    int constant;   /* accepts read-only arrays */
    char record[MAX_NAME]; /* class name of an array's records (src/ulna/engine/records.py), else empty */
    int size;       /* of a record, in bytes */
} Kind;

typedef struct {
    Function function;
    int n_kinds, n_arguments;
    Kind kinds[MAX_KINDS];
} Overload;

typedef struct {
    PyObject_HEAD
    PyMethodDef method; /* the function that Python calls; this entry is its self */
    char *name;
    char result;        /* 'b' True or False, 'i' an integer, '-' None */
    int releases_lock;
    int n_overloads;
    Overload *overloads;
} Entry;

extern PyType_Spec entry_spec;
extern PyTypeObject *entry_type;

/* make_entry(name, ((address, signature), ...), result, releases_lock): the function that Python calls. */
PyObject *make_entry(PyObject *module, PyObject *arguments);
/* Writes the slots of an argument; returns their number, or -1 for another type (no exception is set). */
int take_argument(const Kind *kind, PyObject *argument, int64_t *slots);
/* The number of kinds of an argument: 1, or a tuple and its parts. */
int kinds_of(const Kind *kind);
/* Runs machine code; returns 0, or -1 with a MemoryError. */
int run_machine_code(const Entry *entry, const Overload *overload, const int64_t *slots, int64_t *result);

#endif
