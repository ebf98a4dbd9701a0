/* A utility follows its target with the time constant tau (Wahde 2016, Eq. 8.4), by Euler's method in steps of `longest_s` at most. */
static void brain_follow(brain_real *utility, brain_real target, brain_real seconds, brain_real tau_s, brain_real longest_s) {
  uint16_t parts = brain_parts(seconds / longest_s), i;
  brain_real part = brain_min(seconds / parts / tau_s, 1);
  if (!isfinite(target)) return;
  for (i = 0; i < parts; i++) *utility += (target - *utility) * part;
}
