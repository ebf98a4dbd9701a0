/* A brain for the robot `{robot}`, exported by baudbot. {what}

   In your program, also in an Arduino sketch:

     #include "brain.c"

     static struct brain brain;
     static struct brain_readings readings;
     static struct brain_command command;

     once:          brain_init(&brain);
     in each turn:  readings.at_ns += 1000ull * (micros_now - micros_before);   (both uint32_t)
                    readings.values[...] = ...;  readings.is_new[...] = 1;      (0 for sensors that were not read)
                    brain_turn(&brain, &readings, &command);
                    the motors get command.left and command.right

   Readings, in SI units:
{readings}
   Commands: signals of the motors {limit}; 1 is forwards at full voltage or full speed. Of two servos
   for wheels one is mounted the other way round: its pulse is that of the negative signal.
   A robot stands still at signals of 0.

   Turns may come at any rate; where the brain has probabilities per step, it was made for the rate at which it was tried. Random
   numbers, if it draws any, begin anew with the same stream at each brain_init. No memory is allocated, nothing is printed. On a PC
   compile with -ffp-contract=off, and each turn has the bits that it has in baudbot. With -DBRAIN_SINGLE, and on an AVR, whose double has 32 bits,
   numbers are of single precision. Link with -lm there.
*/
#define BRAIN_SENSORS {sensors}
#define BRAIN_VALUES {values}
{actuators}
