// Waits for a button, then follows a black line by two modules with a digital output, as fast as a potentiometer says.
// ATmega328P at 16 MHz.
//
//     avr-gcc -mmcu=atmega328p -Os -o modules.elf modules.c && avr-objcopy -O ihex modules.elf modules.hex
//
// 2: button to ground. 3, 4: modules, left and right, low over white. 12: switch to the supply. A0: potentiometer.
// 9, 8: PWM and direction of the left motor; 10, 7: of the right one. 13: LED, lit while the switch is closed.

#ifndef F_CPU
#define F_CPU 16000000UL
#endif
#include <avr/io.h>
#include <util/delay.h>

static uint8_t measure(void) {
  ADCSRA |= 1 << ADSC;
  while (ADCSRA & (1 << ADSC));
  return ADCH;
}

// A level that lasts for 20 ms is none of a contact that bounces.
static uint8_t is_pressed(void) {
  uint8_t count = 0;
  while (!(PIND & (1 << PD2)) && ++count < 20) _delay_ms(1);
  return count == 20;
}

int main(void) {
  PORTD = 1 << PD2;
  DDRD = 1 << PD7;
  DDRB = (1 << PB0) | (1 << PB1) | (1 << PB2) | (1 << PB5);
  // Forwards.
  PORTD |= 1 << PD7;
  PORTB |= 1 << PB0;
  TCCR1A = (1 << COM1A1) | (1 << COM1B1) | (1 << WGM10);
  TCCR1B = (1 << WGM12) | (1 << CS11);
  ADMUX = (1 << REFS0) | (1 << ADLAR);
  ADCSRA = (1 << ADEN) | (1 << ADPS2) | (1 << ADPS1) | (1 << ADPS0);
  while (!is_pressed());
  for (;;) {
    if (PINB & (1 << PB4)) PORTB |= 1 << PB5; else PORTB &= ~(1 << PB5);
    uint8_t speed = measure() / 3;
    uint8_t left_black = PIND & (1 << PD3), right_black = PIND & (1 << PD4);
    // The wheel on the side of the line stands.
    OCR1A = left_black && !right_black ? 0 : speed;
    OCR1B = right_black && !left_black ? 0 : speed;
    _delay_ms(2);
  }
}
