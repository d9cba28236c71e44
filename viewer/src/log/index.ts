/** Playing a log back in the page. */

export {
  LogFile,
  type LogFrame,
  type LogRobots,
  type LogScene,
  type Moment,
  type RobotsMoment,
  postScene,
} from './file';
export { type LogListener, Player } from './player';
export { type JointState, type LogClass, type LogRobotState, jointStates } from './robot';
