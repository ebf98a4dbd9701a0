// Four reflectance sensors that discharge a capacitor: the time of each, as libraries for such arrays take it, and motors that follow.
const uint8_t SENSORS[4] = {A0, A1, A2, A3};
const unsigned LONGEST = 2500;
const int LEFT_PWM = 5, LEFT_DIRECTION = 4, RIGHT_PWM = 6, RIGHT_DIRECTION = 7;
unsigned times[4];

void readSensors() {
  for (uint8_t i = 0; i < 4; i++) {
    times[i] = LONGEST;
    digitalWrite(SENSORS[i], HIGH);
    pinMode(SENSORS[i], OUTPUT);
  }
  delayMicroseconds(10);
  for (uint8_t i = 0; i < 4; i++) {
    pinMode(SENSORS[i], INPUT);
    digitalWrite(SENSORS[i], LOW);
  }
  unsigned long start = micros();
  while (micros() - start < LONGEST) {
    unsigned time = micros() - start;
    for (uint8_t i = 0; i < 4; i++) {
      if (digitalRead(SENSORS[i]) == LOW && time < times[i]) {
        times[i] = time;
      }
    }
  }
}

void setup() {
  Serial.begin(115200);
  pinMode(LEFT_DIRECTION, OUTPUT);
  pinMode(RIGHT_DIRECTION, OUTPUT);
  digitalWrite(LEFT_DIRECTION, HIGH);
  digitalWrite(RIGHT_DIRECTION, HIGH);
}

void loop() {
  readSensors();
  unsigned long sum = 0, weighted = 0;
  for (uint8_t i = 0; i < 4; i++) {
    sum += times[i];
    weighted += 1000UL * i * times[i];
    Serial.print(times[i]);
    Serial.print(' ');
  }
  int position = weighted / sum;
  Serial.println(position);
  int turn = (position - 1500) / 20;
  analogWrite(LEFT_PWM, constrain(150 + turn, 0, 255));
  analogWrite(RIGHT_PWM, constrain(150 - turn, 0, 255));
  delay(10);
}
