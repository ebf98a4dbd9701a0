// A wheel with 8 holes at interrupt 0, both edges; a quadrature encoder at interrupt 1, which reads the other channel.
volatile unsigned long holes = 0;
volatile long quarters = 0;

void hole() {
  holes++;
}

void quarter() {
  quarters += digitalRead(3) == digitalRead(4) ? -1 : 1;
}

void setup() {
  Serial.begin(9600);
  pinMode(2, INPUT);
  pinMode(3, INPUT);
  pinMode(4, INPUT);
  attachInterrupt(digitalPinToInterrupt(2), hole, CHANGE);
  attachInterrupt(digitalPinToInterrupt(3), quarter, CHANGE);
}

void loop() {
  static unsigned long next = 1000;
  if (millis() < next) {
    return;
  }
  next += 1000;
  noInterrupts();
  unsigned long h = holes;
  long q = quarters;
  interrupts();
  Serial.print(h);
  Serial.print(' ');
  Serial.println(q);
}
