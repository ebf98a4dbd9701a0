#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVR__)
#include <avr/pgmspace.h>
#define BRAIN_SINGLE
#define BRAIN_FLASH PROGMEM
#define BRAIN_READ(number) pgm_read_float(&(number))
#else
#define BRAIN_FLASH
#define BRAIN_READ(number) (number)
#endif

#ifdef BRAIN_SINGLE
typedef float brain_real;
#else
typedef double brain_real;
#endif

struct brain_readings {
  uint64_t at_ns;                    /* now, in nanoseconds since any instant */
  brain_real values[BRAIN_VALUES];   /* the last readings of all sensors */
  uint8_t is_new[BRAIN_SENSORS];     /* 1 for each sensor that was read since the last turn, else 0 */
};

struct brain_command {
  brain_real left, right;            /* signals of the motors; 1 is full voltage, or the full speed of a regulated motor */
#ifdef BRAIN_ACTUATORS
  brain_real others[BRAIN_ACTUATORS];
#endif
};

