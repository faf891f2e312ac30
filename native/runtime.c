/* What machine code names from outside when Numba has compiled it: memory for an entry's arrays, and a shape for an array in one
piece. Linked into each library of machine code; Numba's own runtime, which does more, is not there. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/* Memory that counts its users: the layout of numba/core/runtime/nrt.h, whose data and count the machine code reads itself. */
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

/* The last user has gone. */
void NRT_MemInfo_call_dtor(void *memory) {
    free(memory);
}

/* The strides of a new shape. All arrays of entries are C-contiguous, so there always are some. */
int numba_attempt_nocopy_reshape(intptr_t n, const intptr_t *shape, const intptr_t *strides, intptr_t n_new, const intptr_t *new_shape,
                                 intptr_t *new_strides, intptr_t item_size, int is_fortran) {
    (void)n, (void)shape, (void)strides, (void)is_fortran;
    for (intptr_t k = n_new - 1; k >= 0; k--) {
        new_strides[k] = item_size;
        item_size *= new_shape[k];
    }
    return 1;
}
