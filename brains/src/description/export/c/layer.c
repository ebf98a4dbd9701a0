/* A layer of neurons: tanh of the bias, which is the last weight of each, and of the weighted sum of the inputs. */
static void brain_layer(const brain_real *weights, uint16_t inputs, uint16_t neurons, const brain_real *in, brain_real *out) {
  uint16_t i, j;
  for (j = 0; j < neurons; j++, weights += inputs + 1) {
    brain_real sum = -0.0;
    for (i = 0; i < inputs; i++) sum += BRAIN_READ(weights[i]) * in[i];
    out[j] = brain_tanh(BRAIN_READ(weights[inputs]) + sum);
  }
}
