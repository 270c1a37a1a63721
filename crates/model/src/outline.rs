//! The outline of body and links, for their clearance to the ground. It carries no force.

use crate::Vec2;

/// Outline of the bars in the nominal pose: the body is the convex hull of a box and its pins, a
/// link the line through its own pins and axles, and the points that it also goes through, from
/// rear to front, outside of its wheels; each is grown by the half width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// Lower rear corner of the body's box, m.
    pub body_lower: Vec2,
    /// Upper front corner of the body's box, m.
    pub body_upper: Vec2,
    /// Half of the width of links, and of the wall about the body's hull, m.
    pub half_width: f64,
    /// Points that links 1 and 2 also go through, m: struts and bends.
    pub through: [[Option<Vec2>; 2]; 2],
}

/// Length and height of the body's box and the half width, over the wheelbase.
const BOX_LENGTH: f64 = 2.0 / 3.0;
const BOX_HEIGHT: f64 = 0.14 / 0.6;
const HALF_WIDTH: f64 = 0.025;

impl Outline {
    /// The outline of a robot of which none is given: a box about the body's centre of mass, 400 x
    /// 140 mm, and bars of 30 mm, for a wheelbase of 0.6 m. Derived, not published: the box has
    /// about the body's inertia, the bars are as high as those of a linkage of this size.
    pub fn derived(axles: &[Vec2; 3], body_cg: Vec2) -> Self {
        let [front, _, rear] = axles;
        let wheelbase = front.x - rear.x;
        let half = Vec2::new(BOX_LENGTH, BOX_HEIGHT) * (0.5 * wheelbase);
        Self {
            body_lower: body_cg - half,
            body_upper: body_cg + half,
            half_width: HALF_WIDTH * wheelbase,
            through: [[None; 2]; 2],
        }
    }
}
