/* Seconds from an instant to another, 0 if that is earlier. */
static brain_real brain_since(uint64_t before_ns, uint64_t now_ns) {
  return now_ns > before_ns ? (brain_real)(now_ns - before_ns) * (brain_real)1e-9 : 0;
}
