//! The layout that opens with the recording: scene on the left, time series on the right.
//!
//! Written part by part, because the SDK's builders cannot set what a view shows (ranges, legends, bounds) and give every
//! part a random name.

use crate::ViewerError;
use crate::rrd::{RrdWriter, TIMELINE};
use crate::scene_view::FOLLOWED;
use crate::series::WHEEL_NAMES;
use re_sdk::{AsComponents, EntityPath};
use re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, PanelBlueprint, PlotLegend, ScalarAxis, TextLogColumns, TimeAxis,
    TimePanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint, VisibleTimeRanges,
    VisualBounds2D,
};
use re_sdk_types::blueprint::components::{
    ContainerKind, Corner2D, LinkAxis, LoopMode, PanelState, PlayState,
};
use re_sdk_types::blueprint::datatypes::{TextLogColumn, TextLogColumnKind};
use re_sdk_types::components::Range1D;
use re_sdk_types::datatypes::{
    Bool, Range1D as Range, Range2D, TimeRange, TimeRangeBoundary, VisibleTimeRange,
};
use re_sdk_types::external::uuid::Uuid;

/// What the layout needs to know of the scene.
pub(crate) struct Shown {
    /// Ground to be seen, m: from, to, lowest, highest.
    pub(crate) ground: [f64; 4],
    /// Static friction coefficient, -: bounds the needed friction.
    pub(crate) mu_s: f64,
}

/// Logs the layout and makes it the one to be used.
pub(crate) fn log(out: &mut RrdWriter, shown: &Shown) -> Result<(), ViewerError> {
    let mut layout = Layout { out, parts: 0 };
    let left = layout.left(shown)?;
    let right = layout.right(shown)?;
    let root = layout.container(
        ContainerKind::Horizontal,
        "robhaz",
        &[(left, 1.0), (right, 1.0)],
    )?;
    layout.viewport(root)?;
    layout.panels()?;
    out.activate_layout()
}

/// A view or container that is logged already.
#[derive(Clone, Copy)]
struct Part {
    kind: &'static str,
    id: Uuid,
}

impl Part {
    fn path(self) -> String {
        format!("{}/{}", self.kind, self.id)
    }
}

/// A property of a view: its name in the layout's store, and its value.
type Property<'a> = (&'static str, &'a dyn AsComponents);

struct Layout<'a> {
    out: &'a mut RrdWriter,
    parts: u128,
}

impl Layout<'_> {
    fn left(&mut self, shown: &Shown) -> Result<Part, ViewerError> {
        let overview = self.overview(shown)?;
        let following = self.following()?;
        let columns =
            [TextLogColumnKind::LogLevel, TextLogColumnKind::Body].map(|kind| TextLogColumn {
                visible: Bool(true),
                kind,
            });
        let columns = TextLogColumns::new().with_text_log_columns(columns);
        let events = self.view(
            "TextLog",
            "Events",
            "events",
            &["+ /events"],
            &[("TextLogColumns", &columns)],
        )?;
        let about = self.view("TextDocument", "About", "about", &["+ /about"], &[])?;
        let words = self.container(ContainerKind::Tabs, "Words", &[(events, 1.0), (about, 1.0)])?;
        self.container(
            ContainerKind::Vertical,
            "Scene",
            &[(overview, 1.0), (following, 2.6), (words, 0.9)],
        )
    }

    fn overview(&mut self, shown: &Shown) -> Result<Part, ViewerError> {
        let [from, to, low, high] = shown.ground;
        // The view has y down. Above the ground the robot, below it the arrows of N.
        let bounds = bounds([from, to], [-(high + 0.45), 0.25 - low]);
        let view = self.view(
            "2D",
            "Whole run [m]",
            "/",
            &[
                "+ /world/**",
                "- /world/follow/**",
                // Too small here for labels and for a second set of arrows.
                "- /world/robot/pins",
                "- /world/forces/estimated/**",
            ],
            &[("VisualBounds2D", &bounds)],
        )?;
        self.show_trails(view)?;
        Ok(view)
    }

    fn following(&mut self) -> Result<Part, ViewerError> {
        let [half_width, above, below] = FOLLOWED.map(f64::from);
        let bounds = bounds([-half_width, half_width], [-above, below]);
        let view = self.view(
            "2D",
            "Along with the body [m]: N and T at the contacts",
            "/world/follow",
            &["+ /world/**"],
            &[("VisualBounds2D", &bounds)],
        )?;
        self.show_trails(view)?;
        Ok(view)
    }

    /// Trails are logged in pieces: a view shows all of them up to the cursor.
    fn show_trails(&mut self, view: Part) -> Result<(), ViewerError> {
        let until_now = VisibleTimeRange {
            timeline: TIMELINE.into(),
            range: TimeRange {
                start: TimeRangeBoundary::Infinite,
                end: TimeRangeBoundary::CursorRelative(0.into()),
            },
        };
        let trails = ViewContents::blueprint_base_visualizer_path_for_entity(
            view.id,
            &EntityPath::from("world/trails"),
        );
        self.out
            .layout(trails, &VisibleTimeRanges::new([until_now]))
    }

    fn right(&mut self, shown: &Shown) -> Result<Part, ViewerError> {
        let normal = self.per_wheel("Normal force N", "normal_force")?;
        let traction = self.per_wheel("Traction T", "traction")?;
        let error = self.per_wheel("Error of N", "error_of_normal_force")?;
        let rms = self.plot(
            "Error of N, RMS of the wheels [N]",
            "series/error_of_normal_force/rms",
            None,
        )?;
        let angle = self.plot("Contact angle [deg]", "series/contact_angle", None)?;
        let most = 1.25 * shown.mu_s;
        let friction = self.plot(
            "Needed friction T/N [-]",
            "series/friction",
            Some(Range1D::new(-most, most)),
        )?;
        let forces = self.tabs("Forces", &[normal, traction, error])?;
        let others = self.tabs("Derived", &[rms, angle, friction])?;
        self.container(
            ContainerKind::Vertical,
            "Time series",
            &[(forces, 3.0), (others, 1.2)],
        )
    }

    fn per_wheel(&mut self, title: &str, quantity: &str) -> Result<Part, ViewerError> {
        let mut views = Vec::new();
        for (i, wheel) in WHEEL_NAMES.iter().enumerate() {
            let entity = format!("series/{quantity}/wheel{}", i + 1);
            let view = self.plot(&format!("{title}, {wheel} wheel [N]"), &entity, None)?;
            views.push((view, 1.0));
        }
        self.container(ContainerKind::Vertical, title, &views)
    }

    fn plot(
        &mut self,
        name: &str,
        entity: &str,
        range: Option<Range1D>,
    ) -> Result<Part, ViewerError> {
        // All plots show the same stretch of time.
        let time = TimeAxis::new().with_link(LinkAxis::LinkToGlobal);
        let legend = PlotLegend::new().with_corner(Corner2D::LeftTop);
        let mut axis = ScalarAxis::new();
        if let Some(range) = range {
            axis = axis.with_range(range);
        }
        self.view(
            "TimeSeries",
            name,
            entity,
            &["$origin"],
            &[
                ("TimeAxis", &time),
                ("PlotLegend", &legend),
                ("ScalarAxis", &axis),
            ],
        )
    }

    fn view(
        &mut self,
        class: &str,
        name: &str,
        origin: &str,
        contents: &[&str],
        properties: &[Property<'_>],
    ) -> Result<Part, ViewerError> {
        let view = self.next("view");
        let path = view.path();
        let blueprint = ViewBlueprint::new(class)
            .with_display_name(name)
            .with_space_origin(origin);
        self.out.layout(path.as_str(), &blueprint)?;
        self.out.layout(
            format!("{path}/ViewContents"),
            &ViewContents::new(contents.iter().copied()),
        )?;
        for (name, property) in properties {
            self.out.layout(format!("{path}/{name}"), *property)?;
        }
        Ok(view)
    }

    fn tabs(&mut self, name: &str, parts: &[Part]) -> Result<Part, ViewerError> {
        let children: Vec<_> = parts.iter().map(|part| (*part, 1.0)).collect();
        self.container(ContainerKind::Tabs, name, &children)
    }

    /// A container of parts with their shares of its length; of tabs the first is on top.
    fn container(
        &mut self,
        kind: ContainerKind,
        name: &str,
        children: &[(Part, f32)],
    ) -> Result<Part, ViewerError> {
        let container = self.next("container");
        let shares = children.iter().map(|(_, share)| *share);
        let mut blueprint = ContainerBlueprint::new(kind)
            .with_display_name(name)
            .with_contents(children.iter().map(|(part, _)| part.path()));
        blueprint = match kind {
            ContainerKind::Horizontal => blueprint.with_col_shares(shares),
            ContainerKind::Vertical => blueprint.with_row_shares(shares),
            ContainerKind::Tabs | ContainerKind::Grid => match children.first() {
                Some((first, _)) => blueprint.with_active_tab(first.path().as_str()),
                None => blueprint,
            },
        };
        self.out.layout(container.path(), &blueprint)?;
        Ok(container)
    }

    fn viewport(&mut self, root: Part) -> Result<(), ViewerError> {
        let viewport = ViewportBlueprint::new()
            .with_root_container(root.id)
            .with_auto_layout(false)
            .with_auto_views(false);
        self.out.layout("viewport", &viewport)
    }

    fn panels(&mut self) -> Result<(), ViewerError> {
        for panel in ["blueprint_panel", "selection_panel"] {
            let collapsed = PanelBlueprint::new().with_state(PanelState::Collapsed);
            self.out.layout(panel, &collapsed)?;
        }
        // Collapsed it still has the cursor and the buttons.
        let time = TimePanelBlueprint::new()
            .with_state(PanelState::Collapsed)
            .with_timeline(TIMELINE)
            .with_play_state(PlayState::Playing)
            .with_loop_mode(LoopMode::All);
        self.out.layout("time_panel", &time)
    }

    fn next(&mut self, kind: &'static str) -> Part {
        self.parts += 1;
        Part {
            kind,
            id: Uuid::from_u128(self.parts),
        }
    }
}

fn bounds(x: [f64; 2], y: [f64; 2]) -> VisualBounds2D {
    VisualBounds2D::new(Range2D {
        x_range: Range(x),
        y_range: Range(y),
    })
}
