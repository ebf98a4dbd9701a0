static brain_real brain_clamp(brain_real x, brain_real least, brain_real most) { return x < least ? least : x > most ? most : x; }
