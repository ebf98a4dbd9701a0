/* Energy flows into a reservoir, and out of it where energy and releaser exceed the spring's force; the flow out at the end. */
static brain_real brain_flow(brain_real *energy, brain_real releaser, brain_real seconds, brain_real fill_hz, brain_real capacity,
                             brain_real outflow_hz, brain_real spring) {
  uint16_t parts = brain_parts(seconds * outflow_hz / (brain_real)0.25), i;
  brain_real part_s = seconds / parts, flow_hz = 0;
  releaser = brain_max(releaser, 0);
  for (i = 0; i < parts; i++) {
    brain_real opening = brain_max(*energy + releaser - spring, 0);
    brain_real there = *energy + part_s * fill_hz;
    brain_real out = brain_min(part_s * outflow_hz * opening, there);
    *energy = brain_min(there - out, capacity);
    flow_hz = out / part_s;
  }
  return flow_hz;
}
