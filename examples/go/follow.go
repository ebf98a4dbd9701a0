// A brain that follows the wall on its right. For one of your own change step, and keep link.go.
package main

import (
	"fmt"
	"log"
	"math"

	pb "follow/build/baudbot/v1"
)

const (
	speed, gain float64 = 0.4, 1.0
	wanted      float64 = 0.3 // nearness of the wall that it keeps: 0 is out of range, 1 is very near
	repeatNs    uint64  = 100_000_000
)

// step is what the brain does in a step. value gives a sensor's last reading, or unread if none has arrived yet.
func step(value func(sensor string, unread float64) float64) *pb.Command {
	ahead := math.Max(value("ir_front", 1), value("ir_front_left", 1))
	if ahead > wanted {
		return &pb.Command{LeftSignal: -0.5 * speed, RightSignal: 0.5 * speed} // a corner: to the left, on the spot
	}
	right := math.Max(value("ir_right", 0), value("ir_front_right", 0))
	// Too near: to the left. The conversion rounds the product, so that no processor fuses it with the sums below.
	turning := float64(gain * speed * (right - wanted))
	return &pb.Command{LeftSignal: speed - turning, RightSignal: speed + turning}
}

// newBrain makes a brain that has driven no robot yet. It gives one command for each message, and another after 0.1 s
// without any, since the cable may have lost the last one.
func newBrain() Brain {
	commandedAtNs := map[uint32]uint64{}
	return func(turn Turn) *pb.RobotStep {
		answer := &pb.RobotStep{Robot: turn.Robot}
		last, commanded := commandedAtNs[turn.Robot]
		wasReset := turn.AtNs < last
		if turn.IsNews() || !commanded || wasReset || turn.AtNs >= last+repeatNs {
			last = turn.AtNs
			commandedAtNs[turn.Robot] = last
			answer.Output = &pb.RobotStep_Command{Command: step(turn.Value)}
		}
		atLatestNs := last + repeatNs
		answer.UntilMessage = &pb.UntilMessage{AtLatestNs: &atLatestNs}
		return answer
	}
}

func main() {
	log.SetFlags(0)
	log.SetPrefix("follow: ")
	tick, err := Drive("follow.go", newBrain)
	if err != nil {
		log.Fatal(err)
	}
	fmt.Printf("the run is over at tick %d\n", tick)
}
