// Drives as it is told, and answers each command with what it sees: the sketch of docs/tutorials/firmware.md. For an `uno-rover`.
//
// A command has two bytes, the duties of the left and the right motor above 128, in halves.

const int LEFT[] = {5, 7, 8}, RIGHT[] = {6, 9, 10};

void motor(const int pins[], int duty) {
  digitalWrite(pins[1], duty > 0);
  digitalWrite(pins[2], duty < 0);
  analogWrite(pins[0], abs(duty));
}

void setup() {
  Serial.begin(9600);
  for (int i = 0; i < 3; i++) {
    pinMode(LEFT[i], OUTPUT);
    pinMode(RIGHT[i], OUTPUT);
  }
}

void loop() {
  if (Serial.available() >= 2) {
    int left = Serial.read() - 128, right = Serial.read() - 128;
    motor(LEFT, 2 * left);
    motor(RIGHT, 2 * right);
    Serial.println(analogRead(A1));
  }
}
