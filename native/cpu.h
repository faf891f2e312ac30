/* The highest level of x86-64, 1 to 4; 0 for another processor. */
int x86_level(void);
