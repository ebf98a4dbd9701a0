//! StandardFirmata as it was released, driven by its protocol.
