/* Wanders: a transition a turn (Wahde 2016, Listings 5.1 and 5.2). */
struct brain_wander { struct brain_chance chance; brain_real signals[2]; uint8_t state; };

/* The signals of each of the ways: forwards, "left" and "right". */
struct brain_wandering { brain_real ways[3][2], turn_probability, stop_turn_probability, left_turn_probability; };

static void brain_wander(struct brain_wander *wander, const struct brain_wandering *p, brain_real *signals) {
  const brain_real *way = wander->signals;
  if (wander->state == 0) {
    way = p->ways[0];
    wander->state = 1;
  } else if (wander->state == 1) {
    if (brain_happens(&wander->chance, p->turn_probability)) {
      way = p->ways[brain_happens(&wander->chance, p->left_turn_probability) ? 1 : 2];
      wander->state = 2;
    }
  } else if (brain_happens(&wander->chance, p->stop_turn_probability)) {
    wander->state = 0;
  }
  signals[0] = wander->signals[0] = way[0];
  signals[1] = wander->signals[1] = way[1];
}
