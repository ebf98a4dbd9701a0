// Five reflectance sensors with voltages; two LEDs show on which side the line is.
const int LEFT = 2, RIGHT = 3;

void setup() {
  Serial.begin(115200);
  pinMode(LEFT, OUTPUT);
  pinMode(RIGHT, OUTPUT);
}

void loop() {
  long sum = 0, weighted = 0;
  for (int i = 0; i < 5; i++) {
    long value = map(analogRead(A0 + i), 100, 900, 0, 1000);
    value = constrain(value, 0L, 1000L);
    sum += value;
    weighted += value * 1000 * i;
  }
  float position = sum ? (float)weighted / sum - 2000.0 : 0;
  digitalWrite(LEFT, position < -100);
  digitalWrite(RIGHT, position > 100);
  Serial.println(position, 1);
  delay(20);
}
