//! The layout of a recording in the viewer: animation, events and flags on the left, time series on
//! the right.
//!
//! The SDK's builders give every part a random name, and cannot set ranges, legends and bounds.

use crate::draw::narrow;
use crate::error::Result;
use crate::estimated_terrain::{LEFT, bounds_of};
use crate::explain::{KEY_HEIGHT, key_width};
use crate::ground::Ground;
use crate::scene_view::followed;
use crate::series::WHEEL_NAMES;
use crate::writer::{TIMELINE, Writer};
use re_log_types::EntityPath;
use re_sdk_types::AsComponents;
use re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, EyeControls3D, LineGrid3D, PanelBlueprint, PlotLegend, ScalarAxis,
    TextLogColumns, TimeAxis, TimePanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint,
    VisibleTimeRanges, VisualBounds2D,
};
use re_sdk_types::blueprint::components::{
    ContainerKind, LinkAxis, LoopMode, PanelState, PlayState,
};
use re_sdk_types::blueprint::datatypes::{TextLogColumn, TextLogColumnKind};
use re_sdk_types::components::Range1D;
use re_sdk_types::datatypes::{
    Bool, Range1D as Range, Range2D, TimeRange, TimeRangeBoundary, VisibleTimeRange,
};
use robhaz_model::{Geometry, WholeRover};
use robhaz_run::{EstimatorDescription, RunDescription};
use robhaz_scene::Scene;
use uuid::Uuid;

/// Number of a part of the layout, and its entity in the layout's store.
type Part = (Uuid, String);
/// A part that is logged.
type Logged = Result<Part>;

/// Logs the layout of a run and makes it the active one. The cursor of a live run stays at the
/// newest record; that of a finished run plays from the start, repeatedly.
pub(crate) fn log(out: &mut Writer, run: &RunDescription) -> Result {
    let mut layout = Layout { out, parts: 0 };
    // Readings without a world have events and flags alone at the left.
    let left = if run.world.is_some() { 1.0 } else { 0.45 };
    let sides = vec![(layout.left(run)?, left), (layout.right(run)?, 1.0)];
    layout.finish(sides)
}

/// Logs the layout of a rover with both sides: the drive in 3-D at the left, plots at the right.
pub(crate) fn log_whole(out: &mut Writer, rover: &WholeRover) -> Result {
    let mut layout = Layout { out, parts: 0 };
    let rows = vec![(layout.drive(rover)?, 4.0), (layout.about()?, 1.0)];
    let left = layout.container(ContainerKind::Vertical, "Scene", rows)?;
    let load = rover.mean_wheel_load();
    let normal = Some(Range1D::new(-0.1 * load, 3.0 * load));
    let traction = Some(Range1D::new(-2.0 * load, 2.0 * load));
    let margin = Some(Range1D::new(0.0, 1.2));
    let mut row = |plots: &[(&str, &str, Option<Range1D>)]| {
        let plots = plots.iter();
        let plots = plots.map(|(title, quantity, range)| layout.plot(title, quantity, *range));
        let plots = plots.collect::<Result<_, _>>()?;
        layout.equal(ContainerKind::Horizontal, "Plots", plots)
    };
    let rows = vec![
        row(&[
            ("N, left wheels [N]", "normal_force/left", normal),
            ("N, right wheels [N]", "normal_force/right", normal),
        ])?,
        row(&[
            ("T, left wheels [N]", "traction/left", traction),
            ("T, right wheels [N]", "traction/right", traction),
        ])?,
        row(&[
            ("Attitude [deg]", "attitude", None),
            ("Tip margin [-]", "tip_margin", margin),
            ("Axial share [-]", "axial_share", None),
        ])?,
    ];
    let right = layout.equal(ContainerKind::Vertical, "Time series", rows)?;
    layout.finish(vec![(left, 1.0), (right, 1.0)])
}

/// Logs a layout part by part, those of a container before it.
struct Layout<'a> {
    out: &'a mut Writer,
    /// Number of parts so far, from which their names follow.
    parts: u128,
}

impl Layout<'_> {
    fn next(&mut self, kind: &str) -> Part {
        self.parts += 1;
        let id = Uuid::from_u128(self.parts);
        (id, format!("{kind}/{id}"))
    }

    /// A view of a class of the viewer, of the entities `contents`.
    fn view(&mut self, class: &str, name: &str, origin: &str, contents: &[&str]) -> Logged {
        let (id, path) = self.next("view");
        let blueprint = ViewBlueprint::new(class)
            .with_display_name(name)
            .with_space_origin(origin);
        self.out.layout(path.as_str(), &blueprint)?;
        let contents = ViewContents::new(contents.iter().copied());
        self.out.layout(format!("{path}/ViewContents"), &contents)?;
        Ok((id, path))
    }

    /// A property of a view, by its name in the layout's store.
    fn property(&mut self, (_, path): &Part, name: &str, value: &dyn AsComponents) -> Result {
        self.out.layout(format!("{path}/{name}"), value)
    }

    /// A view shows all rows of an entity up to the cursor, instead of the newest row alone.
    fn show_past(&mut self, (id, _): &Part, entity: &str) -> Result {
        let entity = EntityPath::from(entity);
        let entity = ViewContents::blueprint_base_visualizer_path_for_entity(*id, &entity);
        let until_now = VisibleTimeRange {
            timeline: TIMELINE.into(),
            range: TimeRange {
                start: TimeRangeBoundary::Infinite,
                end: TimeRangeBoundary::CursorRelative(0.into()),
            },
        };
        let until_now = VisibleTimeRanges::new([until_now]);
        self.out.layout(entity, &until_now)
    }

    /// Parts with their shares of its width or height.
    fn container(&mut self, kind: ContainerKind, name: &str, parts: Vec<(Part, f32)>) -> Logged {
        let (id, path) = self.next("container");
        let shares = parts.iter().map(|(_, share)| *share);
        let blueprint = ContainerBlueprint::new(kind)
            .with_display_name(name)
            .with_contents(parts.iter().map(|((_, path), _)| path.as_str()));
        let blueprint = match (kind, parts.first()) {
            (ContainerKind::Horizontal, _) => blueprint.with_col_shares(shares),
            (ContainerKind::Vertical, _) => blueprint.with_row_shares(shares),
            // The first tab is visible when the recording opens.
            (_, Some(((_, first), _))) => blueprint.with_active_tab(first.as_str()),
            (_, None) => blueprint,
        };
        self.out.layout(path.as_str(), &blueprint)?;
        Ok((id, path))
    }

    /// Parts with equal shares.
    fn equal(&mut self, kind: ContainerKind, name: &str, parts: Vec<Part>) -> Logged {
        let parts = parts.into_iter().map(|part| (part, 1.0));
        self.container(kind, name, parts.collect())
    }

    /// Puts the sides of the window together, and makes the layout the active one.
    fn finish(mut self, sides: Vec<(Part, f32)>) -> Result {
        let (root, _) = self.container(ContainerKind::Horizontal, "robhaz", sides)?;
        let viewport = ViewportBlueprint::new()
            .with_root_container(root)
            .with_auto_layout(false)
            .with_auto_views(false);
        self.out.layout("viewport", &viewport)?;
        panels(self.out)?;
        self.out.activate_layout()
    }

    /// A 2-D view. `bounds` are the visible ranges in the frame of `origin`: left to right and top
    /// to bottom (y down).
    fn spatial(
        &mut self,
        name: &str,
        origin: &str,
        contents: &[&str],
        [x, y]: [[f64; 2]; 2],
    ) -> Logged {
        let view = self.view("2D", name, origin, contents)?;
        let bounds = VisualBounds2D::new(Range2D {
            x_range: Range(x),
            y_range: Range(y),
        });
        self.property(&view, "VisualBounds2D", &bounds)?;
        Ok(view)
    }

    /// A plot over time of the series below `quantity`. `range` is that of the vertical axis;
    /// `None` means the range of the data.
    fn plot(&mut self, name: &str, quantity: &str, range: Option<Range1D>) -> Logged {
        let contents = format!("+ /series/{quantity}/**");
        let view = self.view("TimeSeries", name, "/", &[&contents])?;
        // All plots show the same range of time. The key is a view of its own, so that it does not
        // cover lines.
        let time = TimeAxis::new().with_link(LinkAxis::LinkToGlobal);
        self.property(&view, "TimeAxis", &time)?;
        let legend = PlotLegend::new().with_visible(false);
        self.property(&view, "PlotLegend", &legend)?;
        let axis = ScalarAxis::new();
        let axis = range.map_or(axis.clone(), |range| axis.with_range(range));
        self.property(&view, "ScalarAxis", &axis)?;
        Ok(view)
    }

    /// A list of text messages with their times.
    fn text_log(&mut self, name: &str, entity: &str) -> Logged {
        let view = self.view("TextLog", name, entity, &[&format!("+ {entity}")])?;
        let columns = [TextLogColumnKind::LogLevel, TextLogColumnKind::Body];
        let columns = columns.map(|kind| TextLogColumn {
            visible: Bool(true),
            kind,
        });
        let columns = TextLogColumns::new().with_text_log_columns(columns);
        self.property(&view, "TextLogColumns", &columns)?;
        Ok(view)
    }

    /// Lanes of states over time.
    fn lanes(&mut self, name: &str, entity: &str) -> Logged {
        self.view("StateTimeline", name, entity, &[&format!("+ {entity}/**")])
    }

    fn about(&mut self) -> Logged {
        self.view("TextDocument", "About", "/about", &["+ /about"])
    }

    /// The drive of a rover with both sides, seen from the right, from behind and above, whatever
    /// its size.
    fn drive(&mut self, rover: &WholeRover) -> Logged {
        let name = "The drive [m]: N and T at the contacts";
        let view = self.view("3D", name, "/world/follow", &["+ /world/**"])?;
        let size = rover.side.geometry.wheelbase();
        let eye = EyeControls3D::new()
            .with_position([-1.15, -1.35, 1.2].map(|share| narrow(share * size)))
            .with_look_target([0.0, 0.0, narrow(-0.15 * size)])
            .with_eye_up([0.0, 0.0, 1.0]);
        self.property(&view, "EyeControls3D", &eye)?;
        // The viewer's grid would move with the rover.
        let grid = LineGrid3D::new().with_visible(false);
        self.property(&view, "LineGrid3D", &grid)?;
        self.show_past(&view, "/world/tracks")?;
        Ok(view)
    }

    fn left(&mut self, run: &RunDescription) -> Logged {
        let mut rows = Vec::new();
        if let Some(world) = &run.world {
            rows.push((self.overview(&Ground::new(run, world))?, 1.0));
            rows.push((self.following(&run.robot.robot.geometry)?, 2.5));
        }
        let mut tabs = vec![self.text_log("Events", "/events")?];
        let states = |e: &EstimatorDescription| e.settings.states_covariance();
        if run.world.is_some() || run.estimators.iter().any(states) {
            tabs.push(self.lanes("Wheels", "/wheels")?);
        }
        tabs.push(self.about()?);
        let tabs = self.equal(ContainerKind::Tabs, "Events, wheels, about", tabs)?;
        let trust = self.lanes("Flags of the estimators", "/trust")?;
        let below = vec![(tabs, 1.4), (trust, 1.0)];
        let kind = match run.world {
            Some(_) => ContainerKind::Horizontal,
            None => ContainerKind::Vertical,
        };
        let below = self.container(kind, "What happens", below)?;
        rows.push((below, 1.0));
        self.container(ContainerKind::Vertical, "Scene", rows)
    }

    /// The whole ground of a simulation, with the robot and the paths of its pins.
    fn overview(&mut self, ground: &Ground) -> Logged {
        let contents = [
            "+ /world/**",
            "- /world/follow/**",
            // The robot is too small here for labels, end stops and a second set of arrows.
            "- /world/robot/pins",
            "- /world/robot/link2/stops",
            "- /world/forces/estimated/**",
        ];
        let view = self.spatial("Whole run [m]", "/", &contents, ground.bounds())?;
        self.show_paths(view)
    }

    /// The robot in a view that moves with its body.
    fn following(&mut self, geometry: &Geometry) -> Logged {
        let [half_width, above, below] = followed(geometry);
        // The axis of the whole ground is left out.
        let contents = ["+ /world/**", "- /world/scale/**"];
        let name = "Along with the body [m]: N and T at the contacts";
        let bounds = [[-half_width, half_width], [-above, below]];
        let view = self.spatial(name, "/world/follow", &contents, bounds)?;
        self.show_paths(view)
    }

    /// A view shows the paths of the pins and the ground that was found up to the cursor.
    fn show_paths(&mut self, view: Part) -> Logged {
        for entity in ["world/trails", LEFT, &bounds_of(LEFT)] {
            self.show_past(&view, &format!("/{entity}"))?;
        }
        Ok(view)
    }

    fn right(&mut self, run: &RunDescription) -> Logged {
        let bounds = [[0.0, key_width(run)], [0.0, KEY_HEIGHT]];
        let rows = vec![
            (self.spatial("Lines", "/key", &["+ /key/**"], bounds)?, 0.4),
            (self.forces(run)?, 3.2),
            (self.others(run)?, 1.1),
        ];
        self.container(ContainerKind::Vertical, "Time series", rows)
    }

    /// N, its error and T of each wheel.
    fn forces(&mut self, run: &RunDescription) -> Logged {
        let range = range_of_loads(run, -0.5, 3.0).unwrap_or_else(|| {
            let load = run.robot.robot.mean_wheel_load();
            Range1D::new(-0.1 * load, 3.0 * load)
        });
        let mut tabs = vec![self.per_wheel("Normal force N", "normal_force", Some(range))?];
        if run.has_truth {
            let range = range_of_loads(run, -1.0, 1.0);
            tabs.push(self.per_wheel("Error of N", "error_of_normal_force", range)?);
        }
        let range = range_of_loads(run, -2.0, 2.0);
        tabs.push(self.per_wheel("Traction T", "traction", range)?);
        self.equal(ContainerKind::Tabs, "Forces", tabs)
    }

    fn per_wheel(&mut self, title: &str, quantity: &str, range: Option<Range1D>) -> Logged {
        let plots = (1..).zip(WHEEL_NAMES).map(|(i, wheel)| {
            let title = format!("{title}, {wheel} wheel [N]");
            self.plot(&title, &format!("{quantity}/wheel{i}"), range)
        });
        let plots = plots.collect::<Result<_, _>>()?;
        self.equal(ContainerKind::Vertical, title, plots)
    }

    /// What follows from the forces, and residuals.
    fn others(&mut self, run: &RunDescription) -> Logged {
        let most = run.world.as_ref().map(|w| 1.25 * largest_friction(w));
        let mut plots = Vec::new();
        if run.has_truth {
            let range = range_of_loads(run, 0.0, 1.0);
            let title = "Error of N, RMS of the wheels [N]";
            plots.push((title, "error_of_normal_force/rms", range));
        }
        plots.push(("Contact angle [deg]", "contact_angle", None));
        let needed = most.map(|most| Range1D::new(-most, most));
        plots.push(("Needed friction T/N [-]", "friction", needed));
        if let Some(most) = most {
            let left_over = Range1D::new(-0.25 * most, most);
            plots.push(("Slip margin [-]", "slip_margin", Some(left_over)));
        }
        if run.takes_commands() {
            plots.push(("Commanded torque [N m]", "commanded_torque", None));
        }
        plots.push(("Residual [N]", "residual/force", None));
        plots.push(("Residual [N m]", "residual/moment", None));
        plots.push(("Parity [N]", "parity", None));
        let plots = plots.into_iter();
        let tabs = plots.map(|(title, quantity, range)| self.plot(title, quantity, range));
        let tabs = tabs.collect::<Result<_, _>>()?;
        self.equal(ContainerKind::Tabs, "Derived", tabs)
    }
}

/// Collapses the panels around the views, and sets the movement of the cursor.
fn panels(out: &mut Writer) -> Result {
    for panel in ["blueprint_panel", "selection_panel"] {
        let collapsed = PanelBlueprint::new().with_state(PanelState::Collapsed);
        out.layout(panel, &collapsed)?;
    }
    // The collapsed panel still has the cursor and the buttons.
    let (play, repeat) = match out.is_live() {
        false => (PlayState::Playing, LoopMode::All),
        true => (PlayState::Following, LoopMode::Off),
    };
    let time = TimePanelBlueprint::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(TIMELINE)
        .with_play_state(play)
        .with_loop_mode(repeat);
    out.layout("time_panel", &time)
}

/// The range of an axis on ground with corners, from two multiples of the mean static wheel load,
/// N. Peaks at corners are shorter than a millisecond and would compress all other values. `None`
/// on other ground: the range of the data.
fn range_of_loads(run: &RunDescription, from: f64, to: f64) -> Option<Range1D> {
    let load = run.robot.robot.mean_wheel_load();
    let ground = run.world.as_ref()?.terrain.build(&run.robot.robot);
    (ground.has_corners()).then(|| Range1D::new(from * load, to * load))
}

/// The largest static coefficient of the ground, -.
fn largest_friction(world: &Scene) -> f64 {
    let stretches = world.terrain.stretches.iter().map(|s| s.mu_s);
    stretches.fold(world.friction.mu_s, f64::max)
}
