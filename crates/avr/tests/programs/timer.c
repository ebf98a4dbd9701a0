// A timer in all its modes, for comparison with another simulator. -DNUMBER is its number; -DPROGRAM chooses what is looked at:
// COUNTERS    what the program reads of the counter and of the flags, with each division;
// OUTPUTS     the edges at OCnA and OCnB;
// INTERRUPTS  the instants of the interrupts, which toggle PB4.
// PB5 is toggled before and behind each part that matters. What is read is in a buffer in memory, the number of results first.
// 0xA5 in GPIOR0 says that all is done.
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>

#define COUNTERS 1
#define OUTPUTS 2
#define INTERRUPTS 3

#define GLUE(a, b, c) a##b##c
#define NAME(a, b, c) GLUE(a, b, c)
#define CONTROL_A NAME(TCCR, NUMBER, A)
#define CONTROL_B NAME(TCCR, NUMBER, B)
#if NUMBER == 1
#define FORCE TCCR1C
#else
#define FORCE CONTROL_B
#endif
#define COUNT NAME(TCNT, NUMBER, )
#define COMPARE_A NAME(OCR, NUMBER, A)
#define COMPARE_B NAME(OCR, NUMBER, B)
#define FLAGS NAME(TIFR, NUMBER, )
#define MASK NAME(TIMSK, NUMBER, )

// Instructions of one cycle each, so that nothing waits for the end of a longer one. Functions, as no branch reaches over them.
#define NOPS(n) \
	__attribute__((noinline, unused)) static void nops_##n(void) \
	{ \
		asm volatile(".rept " #n "\n nop\n .endr"); \
	}
NOPS(37)
NOPS(97)
NOPS(301)
NOPS(1500)
NOPS(1800)

// The prescalers begin from zero 1024 cycles before the clock is chosen, so that it does not matter whether choosing it restarts
// them.
static void start(uint8_t control_b)
{
	uint16_t wait;
	asm volatile("out %[gtccr], %[reset]\n"
		     "ldi %A[wait], 255\n"
		     "ldi %B[wait], 0\n"
		     "1: sbiw %[wait], 1\n"
		     "brne 1b\n"
		     "nop\n"
		     "st Z, %[control]\n"
		     : [wait] "=&w"(wait)
		     : [gtccr] "I"(_SFR_IO_ADDR(GTCCR)), [reset] "r"((uint8_t)(1 << PSRASY | 1 << PSRSYNC)),
		       "z"(&CONTROL_B), [control] "r"(control_b));
}

// Sets the timer up in a mode, with its clock off.
static void set_up(uint8_t mode, uint8_t outputs, uint16_t top, uint16_t a, uint16_t b)
{
	CONTROL_B = 0;
	// The outputs begin low.
	CONTROL_A = 0xA0;
	FORCE = 0xC0;
	CONTROL_A = 0;
	COUNT = 0;
	// Where nothing is buffered.
	COMPARE_A = a;
	COMPARE_B = b;
#if NUMBER == 1
	// ICR1 can be written only while it is the top.
	CONTROL_B = 1 << WGM13;
	ICR1 = top;
	CONTROL_B = (mode >> 2 & 3) << WGM12;
#else
	CONTROL_B = (mode >> 2 & 1) << WGM02;
#endif
	CONTROL_A = outputs | (mode & 3);
	FLAGS = NUMBER == 1 ? 0x27 : 0x07;
	PINB = 1 << PB5;
}

static uint8_t with_mode(uint8_t mode, uint8_t clock)
{
	return mode >> 2 << 3 | clock;
}

#if NUMBER == 1
static const uint8_t modes[] PROGMEM = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14, 15};
#define LAST_CLOCK 5
#else
static const uint8_t modes[] PROGMEM = {0, 1, 2, 3, 5, 7};
#define LAST_CLOCK (NUMBER == 2 ? 7 : 5)
#endif

#if PROGRAM == COUNTERS
static volatile struct {
	uint16_t count;
	uint16_t results[800];
} found;

static void put(uint16_t result)
{
	found.results[found.count++] = result;
}

static void look(void)
{
	put(COUNT);
	put(FLAGS);
}

static void counters(uint8_t mode, uint8_t clock)
{
	set_up(mode, 0, 173, 211, 59);
	start(with_mode(mode, clock));
	look();
	nops_37();
	look();
	for (uint16_t wait = clock * clock * clock * 3; wait; wait--)
		nops_97();
	look();
	nops_301();
	look();
}
#endif

#if PROGRAM == OUTPUTS
static void outputs(uint8_t mode, uint8_t clock, uint8_t com)
{
	set_up(mode, com, 173, 211, 59);
	start(with_mode(mode, clock));
	nops_1500();
	// Buffered where the mode says so.
	COMPARE_B = 101;
	nops_1500();
	PINB = 1 << PB5;
	CONTROL_B = with_mode(mode, 0);
}
#endif

#if PROGRAM == INTERRUPTS
#define ISR_NAME(timer, event) GLUE(TIMER, timer, _##event##_vect)
#define TOGGLE(event) \
	ISR(ISR_NAME(NUMBER, event), ISR_NAKED) \
	{ \
		asm volatile("sbi %0, 4\n reti" : : "I"(_SFR_IO_ADDR(PINB))); \
	}
TOGGLE(OVF)
TOGGLE(COMPA)
TOGGLE(COMPB)

static void interrupts(uint8_t mode, uint8_t clock, uint8_t mask)
{
	set_up(mode, 0, 173, 211, 59);
	MASK = mask;
	start(with_mode(mode, clock));
	sei();
	nops_1800();
	cli();
	PINB = 1 << PB5;
	MASK = 0;
}
#endif

int main(void)
{
	DDRB = 1 << PB5 | 1 << PB4 | 1 << PB1 | 1 << PB2 | 1 << PB3;
	DDRD = 1 << PD3 | 1 << PD5 | 1 << PD6;
	for (uint8_t i = 0; i < sizeof modes; i++) {
		uint8_t mode = pgm_read_byte(modes + i);
#if PROGRAM == COUNTERS
		for (uint8_t clock = 1; clock <= LAST_CLOCK; clock++)
			counters(mode, clock);
#elif PROGRAM == OUTPUTS
		outputs(mode, 1, 0xA0);
		outputs(mode, 2, 0xF0);
		outputs(mode, 1, 0x40);
#else
		interrupts(mode, 1, 1 << TOIE0);
		interrupts(mode, 2, 1 << OCIE0A);
		interrupts(mode, 1, 1 << OCIE0B);
#endif
	}
	GPIOR0 = 0xA5;
	for (;;)
		;
}
