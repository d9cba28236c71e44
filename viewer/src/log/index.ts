/** Playing a log back in the page. */

export { LogFile, type LogRobots, type Moment, type RobotsMoment } from './file';
export { type LogListener, Player } from './player';
export { jointStates } from './robot';
