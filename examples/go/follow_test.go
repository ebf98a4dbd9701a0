package main

import (
	"testing"

	pb "follow/build/baudbot/v1"
)

func stepWith(values map[string]float64) *pb.Command {
	return step(func(sensor string, unread float64) float64 {
		if value, read := values[sensor]; read {
			return value
		}
		return unread
	})
}

func TestTurnsOnTheSpotBeforeAnyReading(t *testing.T) {
	if c := stepWith(nil); c.LeftSignal != -0.2 || c.RightSignal != 0.2 {
		t.Errorf("it must turn to the left, is %v", c)
	}
}

func TestDrivesStraightAtTheWantedNearness(t *testing.T) {
	c := stepWith(map[string]float64{"ir_front": 0, "ir_front_left": 0, "ir_right": wanted})
	if c.LeftSignal != speed || c.RightSignal != speed {
		t.Errorf("both signals must be %v, is %v", speed, c)
	}
}

func TestTurnsAwayFromAWallThatIsTooNear(t *testing.T) {
	c := stepWith(map[string]float64{"ir_front": 0, "ir_front_left": 0, "ir_right": 0.1, "ir_front_right": 0.9})
	if c.LeftSignal >= c.RightSignal {
		t.Errorf("it must turn to the left, is %v", c)
	}
}

func TestCommandsAgainAfterATenthOfASecondAndAfterAReset(t *testing.T) {
	brain := newBrain()
	for _, when := range []struct {
		atMs     uint64
		news     bool
		commands bool
	}{{500, false, true}, {510, false, false}, {520, true, true}, {620, false, true}, {10, false, true}} {
		answer := brain(Turn{&pb.RobotTurn{AtNs: when.atMs * 1_000_000, HasMessage: when.news}, &pb.RobotDescription{}})
		if commands := answer.GetCommand() != nil; commands != when.commands {
			t.Errorf("at %d ms: commands must be %v, is %v", when.atMs, when.commands, commands)
		}
	}
}

func TestDrivesUntilTheRunIsOver(t *testing.T) {
	t.Setenv("BAUDBOT_CONNECT", startServer(t, "--pace", "lockstep", "--set", "end.after_s=10.0"))
	forwards := 0
	tick, err := Drive("follow.go", func() Brain {
		brain := newBrain()
		return func(turn Turn) *pb.RobotStep {
			answer := brain(turn)
			if c := answer.GetCommand(); c != nil && c.LeftSignal > 0 && c.RightSignal > 0 {
				forwards++
			}
			return answer
		}
	})
	if err != nil || tick != 1000 {
		t.Fatalf("the run must be over at tick 1000, is over at %d: %v", tick, err)
	}
	if forwards == 0 {
		t.Error("no command drives forwards")
	}
}
