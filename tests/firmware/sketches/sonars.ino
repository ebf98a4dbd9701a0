// A PING))) on pin 7 and an HC-SR04 on pins 9 and 10, by pulseIn.
const int PING = 7, TRIGGER = 9, ECHO = 10;

unsigned long onePin() {
  pinMode(PING, OUTPUT);
  digitalWrite(PING, LOW);
  delayMicroseconds(2);
  digitalWrite(PING, HIGH);
  delayMicroseconds(5);
  digitalWrite(PING, LOW);
  pinMode(PING, INPUT);
  return pulseIn(PING, HIGH);
}

unsigned long twoPins() {
  digitalWrite(TRIGGER, LOW);
  delayMicroseconds(2);
  digitalWrite(TRIGGER, HIGH);
  delayMicroseconds(10);
  digitalWrite(TRIGGER, LOW);
  return pulseIn(ECHO, HIGH, 30000);
}

void setup() {
  Serial.begin(9600);
  pinMode(TRIGGER, OUTPUT);
  pinMode(ECHO, INPUT);
}

void loop() {
  unsigned long first = onePin();
  unsigned long second = twoPins();
  Serial.print(first);
  Serial.print(' ');
  Serial.print(second);
  Serial.print(' ');
  Serial.print(first / 29.0 / 2.0);
  Serial.println(F(" cm"));
  delay(50);
}
