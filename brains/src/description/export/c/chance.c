/* A stream of random numbers: PCG XSL RR 128/64 (O'Neill 2014), the same as that of the brain in baudbot. */
struct brain_chance { uint64_t high, low, step_high, step_low; };

/* A number in [0, 1), with 53 random bits. */
static brain_real brain_uniform(struct brain_chance *chance) {
  const uint64_t times_high = 0x2360ed051fc65da4ull, times_low = 0x4385df649fccf645ull;
  const uint64_t a = chance->low >> 32, b = chance->low & 0xffffffff, c = times_low >> 32, d = times_low & 0xffffffff;
  const uint64_t ad = a * d + (b * d >> 32), bc = b * c + (ad & 0xffffffff);
  uint64_t high = chance->low * times_high + chance->high * times_low + a * c + (ad >> 32) + (bc >> 32);
  uint64_t low = chance->low * times_low + chance->step_low, mixed;
  uint8_t turned;
  high += chance->step_high + (low < chance->step_low);
  chance->high = high;
  chance->low = low;
  turned = (uint8_t)(high >> 58);
  mixed = high ^ low;
  mixed = mixed >> turned | mixed << ((64 - turned) & 63);
  return (brain_real)(mixed >> 11) / (brain_real)9007199254740992.0;
}

static uint8_t brain_happens(struct brain_chance *chance, brain_real probability) { return brain_uniform(chance) < probability; }
