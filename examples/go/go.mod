// For editors, and for modules from the network (`go mod tidy`). `make` takes Debian's packages, which are no modules.
module follow

go 1.19

require (
	google.golang.org/grpc v1.33.3
	google.golang.org/protobuf v1.28.1
)
