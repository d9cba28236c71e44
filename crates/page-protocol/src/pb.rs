//! The messages of `proto/live.proto`.
#![expect(missing_docs, reason = "the file has the documentation")]

include!(concat!(env!("OUT_DIR"), "/live.rs"));
