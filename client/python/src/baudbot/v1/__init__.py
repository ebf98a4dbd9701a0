"""The contract `baudbot.v1`, as protobuf's and gRPC's generators make it (`client/python/generate`)."""
