/* The greater of two numbers; what is not a number does not count. */
static brain_real brain_max(brain_real a, brain_real b) { return a > b || b != b ? a : b; }
