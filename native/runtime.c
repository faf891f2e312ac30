/* The external functions of machine code that Numba has compiled: memory for an entry's arrays, and reshaping of contiguous arrays.
Linked into each library of machine code in place of Numba's own runtime, which does more. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/* Reference-counted memory in the layout of numba/core/runtime/nrt.h; the machine code reads data and count itself. */
typedef struct {
    size_t users;
    void (*destroy)(void *data, size_t size, void *with);
    void *destroy_with;
    void *data;
    size_t size;
    void *allocator;
} Memory;

void *NRT_MemInfo_alloc_aligned(size_t size, unsigned alignment) {
    if (alignment < 1) alignment = 1;
    if (size > SIZE_MAX - sizeof(Memory) - alignment) return NULL;
    Memory *memory = malloc(sizeof(Memory) + size + alignment);
    if (!memory) return NULL;
    uintptr_t start = (uintptr_t)(memory + 1), over = start % alignment;
    memory->users = 1;
    memory->destroy = NULL;
    memory->destroy_with = NULL;
    memory->data = (void *)(over ? start + alignment - over : start);
    memory->size = size;
    memory->allocator = NULL;
    return memory;
}

/* Frees memory without users. */
void NRT_MemInfo_call_dtor(void *memory) {
    free(memory);
}

/* The strides of a new shape, which always exist, as all arrays of entries are C-contiguous. */
int numba_attempt_nocopy_reshape(intptr_t n, const intptr_t *shape, const intptr_t *strides, intptr_t n_new, const intptr_t *new_shape,
                                 intptr_t *new_strides, intptr_t item_size, int is_fortran) {
    (void)n, (void)shape, (void)strides, (void)is_fortran;
    for (intptr_t k = n_new - 1; k >= 0; k--) {
        new_strides[k] = item_size;
        item_size *= new_shape[k];
    }
    return 1;
}
