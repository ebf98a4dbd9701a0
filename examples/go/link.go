package main

import (
	"context"
	"errors"
	"io"
	"log"
	"strings"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/keepalive"
	"google.golang.org/grpc/metadata"
	"google.golang.org/grpc/status"

	pb "follow/build/baudbot/v1"
)

// Brain answers the turns of all robots of a connection.
type Brain func(Turn) *pb.RobotStep

// Drive drives the robots that the environment names until the run is over, and gives its last tick. Each connection gets
// a new brain, since the world may have changed. The server shows the program's name.
func Drive(program string, newBrain func() Brain) (uint64, error) {
	address, err := findAddress()
	if err != nil {
		return 0, err
	}
	reconnectS, err := findReconnectS()
	if err != nil {
		return 0, err
	}
	wasAttached, lostAt := false, time.Time{}
	for {
		token, err := findToken(address)
		if err != nil {
			return 0, err
		}
		tick, attached, err := attach(address, token, program, newBrain())
		if err == nil {
			return tick, nil
		}
		if attached {
			wasAttached, lostAt = true, time.Time{}
		}
		message := errors.New(status.Convert(err).Message())
		if reconnectS <= 0 || !isLost(status.Code(err), wasAttached, address, token) {
			return 0, message
		}
		if lostAt.IsZero() {
			lostAt = time.Now()
			log.Printf("connection lost (%v); trying again for %v s", message, reconnectS)
		} else if time.Since(lostAt).Seconds() >= reconnectS {
			return 0, message
		}
		time.Sleep(500 * time.Millisecond)
	}
}

// isLost says whether another try may succeed.
func isLost(code codes.Code, wasAttached bool, address, token string) bool {
	switch code {
	case codes.AlreadyExists: // perhaps by this program's last connection, if the server has not noticed that it is gone
		return wasAttached
	case codes.Unauthenticated: // perhaps by the last server's token, if this one wrote its own after it had begun to listen
		newest, err := findToken(address)
		return err == nil && newest != token
	}
	return code == codes.Unavailable
}

// attach drives in one connection, which is new since gRPC would wait longer and longer before it tried again.
func attach(address, token, program string, brain Brain) (tick uint64, attached bool, err error) {
	server, err := grpc.Dial(address, grpc.WithInsecure(), grpc.WithNoProxy(),
		grpc.WithKeepaliveParams(keepalive.ClientParameters{Time: 20 * time.Second, Timeout: 20 * time.Second}))
	if err != nil {
		return 0, false, err
	}
	defer server.Close()
	ctx := context.Background()
	if token != "" {
		ctx = metadata.AppendToOutgoingContext(ctx, "authorization", "Bearer "+token)
	}
	stream, err := pb.NewBrainLinkServiceClient(server).Attach(ctx)
	if err != nil {
		return 0, false, err
	}
	// If one of these cannot be sent, Recv has the reason.
	_ = stream.Send(&pb.AttachRequest{Request: &pb.AttachRequest_Hello{Hello: &pb.Hello{
		World: env("BAUDBOT_WORLD", "wander"), Robots: strings.Split(env("BAUDBOT_ROBOT", "robot"), ","),
		Mode: pb.PortMode_PORT_MODE_MESSAGES, Brain: program, ThinksAsScenario: true,
	}}})
	var bodies []*pb.RobotDescription
	for {
		response, err := stream.Recv()
		if err == io.EOF {
			return 0, attached, status.Error(codes.Unavailable, "the server closed the connection before the run was over")
		} else if err != nil && strings.Join(stream.Trailer().Get("baudbot-reason"), "") == "restart" {
			return 0, attached, status.Error(codes.Unavailable, status.Convert(err).Message()) // as if it were lost
		} else if err != nil {
			return 0, attached, err
		}
		switch response := response.Response.(type) {
		case *pb.AttachResponse_Welcome:
			bodies, attached = response.Welcome.Robots, true
		case *pb.AttachResponse_Turn:
			step := &pb.Step{Turn: response.Turn.Turn}
			for _, robot := range response.Turn.Robots {
				step.Robots = append(step.Robots, brain(Turn{robot, bodies[robot.Robot]}))
			}
			_ = stream.Send(&pb.AttachRequest{Request: &pb.AttachRequest_Step{Step: step}})
		case *pb.AttachResponse_Ended:
			return response.Ended.Tick, attached, stream.CloseSend()
		}
	}
}
