"""The ground floor: message types, their protobuf schemas, the table of topics, the Zenoh session."""
