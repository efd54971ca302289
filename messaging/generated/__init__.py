"""Code that protoc made from messaging/proto; `make protobuf` makes it anew."""
