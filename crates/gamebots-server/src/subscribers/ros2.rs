//! The node of ROS 2 as a listener of the world.

use std::path::PathBuf;

use recorder::RecordError;
use ros2::Feed;
use served_world::Told;
use sessions::News;
use sim_core::World;

use crate::subscribers::subscriber::{Moment, Shot, Subscriber};

impl Subscriber for Feed {
    fn hear(&mut self, moment: &mut Moment, event: &Told) {
        if let Told::News(News::Sensed(sensed)) = event {
            self.sensed(moment.world, sensed, || moment.present.of(moment.world));
        }
    }

    fn stepped(&mut self, moment: &mut Moment) -> Vec<Shot> {
        let Moment { world, now, present, .. } = moment;
        Feed::stepped(self, world, *now, || present.of(world));
        Vec::new()
    }

    fn publish(&mut self, moment: &mut Moment) -> Vec<String> {
        let Moment { world, now, present, .. } = moment;
        self.turned(world, *now, || present.of(world));
        Vec::new()
    }

    fn start_over(&mut self, _: &mut Moment, _: &World) -> Vec<String> {
        Feed::start_over(self);
        Vec::new()
    }

    fn end(&mut self, _: &mut Moment, _: Option<&str>) -> Option<Result<PathBuf, RecordError>> {
        Feed::end(self);
        None
    }
}
