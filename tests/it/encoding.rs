//! CDR on the wire: pinned bytes, alignment, and bytes that are refused.

use toile::wire::cdr::{self, CdrError};
use toile::wire::messages::{
    builtin_interfaces::Time, sensor_msgs, std_msgs, tf2_msgs, toile_msgs,
};

use crate::messages::sample_report;

#[test]
fn cdr_bytes_are_pinned() {
    let report = std_msgs::Header {
        stamp: Time { sec: 1, nanosec: 2 },
        frame_id: "ab".into(),
    };
    let bytes = cdr::encode(&report).expect("encodes");
    let expected = [
        0, 1, 0, 0, // encapsulation: CDR, little endian
        1, 0, 0, 0, // sec
        2, 0, 0, 0, // nanosec
        3, 0, 0, 0, b'a', b'b', 0, // length with the terminator, text
    ];
    assert_eq!(bytes, expected);
}

#[test]
fn cdr_aligns_to_the_body() {
    let cloud = sensor_msgs::PointField {
        name: "x".into(),
        offset: 4,
        datatype: 7,
        count: 1,
    };
    let bytes = cdr::encode(&cloud).expect("encodes");
    let expected = [
        0, 1, 0, 0, 2, 0, 0, 0, b'x', 0, 0, 0, 4, 0, 0, 0, 7, 0, 0, 0, 1, 0, 0, 0,
    ];
    assert_eq!(bytes, expected);
}

#[test]
fn bad_bytes_are_refused() {
    let good = cdr::encode(&sample_report()).expect("encodes");
    for cut in 0..good.len() {
        assert!(
            cdr::decode::<toile_msgs::StepReport>(&good[..cut]).is_err(),
            "cut at {cut}"
        );
    }
    let parameter_list = [0, 3, 0, 0];
    let refused = cdr::decode::<Time>(&parameter_list);
    assert!(matches!(refused, Err(CdrError::Encapsulation { .. })));
    let absurd = [0, 1, 0, 0, 255, 255, 255, 255, 0];
    assert!(cdr::decode::<std_msgs::String>(&absurd).is_err());
    assert!(cdr::decode::<tf2_msgs::TFMessage>(&absurd).is_err());
}
