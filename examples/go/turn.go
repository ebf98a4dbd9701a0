package main

import pb "follow/build/baudbot/v1"

// Turn is what a robot's brain learns in a step, and the robot's data sheet.
type Turn struct {
	*pb.RobotTurn
	Body *pb.RobotDescription
}

// Value gives the last reading of a sensor, the first one of several values, or unread if none has arrived yet.
func (t Turn) Value(sensor string, unread float64) float64 {
	for _, reading := range t.Readings {
		if t.Body.Sensors[reading.Sensor].Sensor == sensor && len(reading.Values) > 0 {
			return reading.Values[0]
		}
	}
	return unread
}

// IsNews says whether anything has arrived since the last turn: the server asks in ticks without news, too.
func (t Turn) IsNews() bool {
	for _, reading := range t.Readings {
		if reading.Readable {
			return true
		}
	}
	return t.HasMessage
}
