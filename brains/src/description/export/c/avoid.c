/* Drives on, more slowly the nearer something is; escapes from what is too near; strolls at random. */
enum { BRAIN_DRIVES, BRAIN_ESCAPES, BRAIN_STROLLS };
struct brain_avoid { struct brain_chance chance; uint64_t decided_ns; int8_t way; uint8_t state, has_news; };
struct brain_eye { uint64_t seen_ns; brain_real reading; uint8_t has_seen; };

/* The sensor of an eye, its place among the values, and its side: 1 is left, -1 right. */
struct brain_look { uint16_t sensor, value; int8_t side; };
struct brain_caution {
  brain_real forward, creep, turn, slow_reading, turn_reading, clear_reading, stroll_rate_hz, stop_stroll_rate_hz;
  uint64_t stale_ns;
};

static int8_t brain_any_way(struct brain_avoid *avoid) { return brain_happens(&avoid->chance, (brain_real)0.5) ? 1 : -1; }

/* The greatest readings: of all eyes, of those on the left, and of those on the right. */
static void brain_avoid_decide(struct brain_avoid *avoid, const struct brain_caution *p, const brain_real *nearest, brain_real seconds) {
  if (avoid->state == BRAIN_ESCAPES && nearest[0] >= p->clear_reading) return;
  if (nearest[0] >= p->turn_reading) {
    if (avoid->state != BRAIN_STROLLS) avoid->way = nearest[1] > nearest[2] ? -1 : nearest[2] > nearest[1] ? 1 : brain_any_way(avoid);
    avoid->state = BRAIN_ESCAPES;
  } else if (avoid->state == BRAIN_STROLLS) {
    if (brain_happens(&avoid->chance, p->stop_stroll_rate_hz * seconds)) avoid->state = BRAIN_DRIVES;
  } else if (avoid->state == BRAIN_DRIVES && brain_happens(&avoid->chance, p->stroll_rate_hz * seconds)) {
    avoid->state = BRAIN_STROLLS;
    avoid->way = brain_any_way(avoid);
  } else {
    avoid->state = BRAIN_DRIVES;
  }
}

static void brain_avoid(struct brain_avoid *avoid, const struct brain_caution *p, struct brain_eye *eyes, const struct brain_look *looks,
                        uint16_t count, const struct brain_readings *readings, brain_real *signals) {
  brain_real nearest[3] = {0, 0, 0}, way;
  uint8_t is_blind = 0;
  uint16_t i;
  for (i = 0; i < count; i++) {
    struct brain_eye *eye = &eyes[i];
    if (readings->is_new[looks[i].sensor]) {
      eye->reading = readings->values[looks[i].value];
      eye->seen_ns = readings->at_ns;
      eye->has_seen = avoid->has_news = 1;
    }
    if (!eye->has_seen || (readings->at_ns > eye->seen_ns && readings->at_ns - eye->seen_ns > p->stale_ns)) is_blind = 1;
    nearest[0] = brain_max(nearest[0], eye->reading);
    if (looks[i].side > 0) nearest[1] = brain_max(nearest[1], eye->reading);
    if (looks[i].side < 0) nearest[2] = brain_max(nearest[2], eye->reading);
  }
  if (is_blind) {
    avoid->state = BRAIN_DRIVES;
    signals[0] = signals[1] = 0;
    return;
  }
  if (avoid->has_news) {
    brain_avoid_decide(avoid, p, nearest, brain_since(avoid->decided_ns, readings->at_ns));
    avoid->decided_ns = readings->at_ns;
    avoid->has_news = 0;
  }
  if (avoid->state == BRAIN_DRIVES) {
    way = (nearest[0] - p->slow_reading) / brain_max(p->turn_reading - p->slow_reading, (brain_real)1e-9);
    signals[0] = signals[1] = p->forward + (p->creep - p->forward) * brain_clamp(way, 0, 1);
  } else {
    signals[0] = avoid->way > 0 ? -p->turn : p->turn;
    signals[1] = -signals[0];
  }
}
