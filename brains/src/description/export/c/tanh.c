#ifdef BRAIN_SINGLE
static brain_real brain_tanh(brain_real x) { return tanhf(x); }
#else
/* tanh as baudbot computes it, by musl's tanh and FreeBSD's expm1, so that every bit agrees.
   Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
   Developed at SunPro, a Sun Microsystems, Inc. business. Permission to use, copy, modify, and distribute this software is freely
   granted, provided that this notice is preserved. */
static uint64_t brain_bits(double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

static double brain_power_of_2(int k) {
  uint64_t bits = (uint64_t)(0x3ff + k) << 52;
  double power;
  memcpy(&power, &bits, sizeof power);
  return power;
}

/* e to the x, minus 1, for 2^-1021 <= |x| <= 40. */
static double brain_expm1(double x) {
  const double ln2_high = 6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10;
  uint32_t top = (uint32_t)(brain_bits(x) >> 32) & 0x7fffffff;
  double high, low, lost = 0.0, half, square, r, t, e, power;
  int k = 0;
  if (top > 0x3fd62e42) {
    if (top < 0x3ff0a2b2) {
      k = x < 0.0 ? -1 : 1;
    } else {
      k = (int)(1.44269504088896338700e+00 * x + (x < 0.0 ? -0.5 : 0.5));
    }
    high = x - k * ln2_high;
    low = k * ln2_low;
    x = high - low;
    lost = (high - x) - low;
  } else if (top < 0x3c900000) {
    return x;
  }
  half = 0.5 * x;
  square = x * half;
  r = 1.0 + square * (-3.33333333333331316428e-02 + square * (1.58730158725481460165e-03 + square * (-7.93650757867487942473e-05
    + square * (4.00821782732936239552e-06 + square * -2.01099218183624371326e-07))));
  t = 3.0 - r * half;
  e = square * ((r - t) / (6.0 - x * t));
  if (k == 0) return x - (x * e - square);
  e = x * (e - lost) - lost;
  e -= square;
  if (k == -1) return 0.5 * (x - e) - 0.5;
  if (k == 1) return x < -0.25 ? -2.0 * (e - (x + 0.5)) : 1.0 + 2.0 * (x - e);
  power = brain_power_of_2(k);
  if (k < 0 || k > 56) return (x - e + 1.0) * power - 1.0;
  t = brain_power_of_2(-k);
  return k < 20 ? (x - e + (1.0 - t)) * power : (x - (e + t) + 1.0) * power;
}

static brain_real brain_tanh(brain_real x) {
  double size = brain_bits(x) >> 63 ? -x : x, t = size;
  uint32_t top = (uint32_t)(brain_bits(size) >> 32);
  if (top > 0x3fe193ea) {
    t = top > 0x40340000 ? 1.0 - 0.0 / size : 1.0 - 2.0 / (brain_expm1(2.0 * size) + 2.0);
  } else if (top > 0x3fd058ae) {
    t = brain_expm1(2.0 * size);
    t = t / (t + 2.0);
  } else if (top >= 0x00100000) {
    t = brain_expm1(-2.0 * size);
    t = -t / (t + 2.0);
  }
  return brain_bits(x) >> 63 ? -t : t;
}
#endif
