// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/** The state of a session. Order of IM2FIT_STATE_... */
enum class State {
    /** No person yet. */
    SEARCHING,
    /** A person is found but cannot be measured yet: see the guidance. */
    USER_FOUND,
    /** Waiting for the calibration pose. */
    CALIBRATING,
    /** Frames are being accumulated. */
    TRACKING,
    /** The measurement is complete. */
    MEASURED,
    /** The person has left. */
    LOST,
    /** [Settings.turn]: the front is measured, frames of the back or of the turn are being accumulated. */
    TURNING
}

/** What must change about the person or the scene. Order of the bits IM2FIT_GUIDANCE_... */
enum class Guidance {
    NO_PERSON, TOO_NEAR, TOO_FAR, FEET_CUT, HEAD_CUT, ARMS_CLOSE, NOT_FRONTAL, NOT_UPRIGHT, MOVING, SEVERAL_PEOPLE,
    TOO_NOISY, SIDE_CUT, CALIBRATION_POSE, TURN_ROUND,
    /** Measured, but clothes were detected although [Settings.clothing] is BARE. */
    CLOTHED,
    /** Make one full turn slowly on the spot. */
    TURN_ON,
    /** Turn or walk more slowly. */
    TURN_SLOWER,
    /** For the holder of the phone: continue to walk round the person. */
    WALK_ROUND,
    /** Not measured: the person is shorter or taller than all training people. */
    OUT_OF_POPULATION,
    /** Not measured: the floor is curved in the depth. The lens is not corrected, or frames hold distances, not depths. */
    FLOOR_BENT,
    /** The feet are on an object above the floor, and heights are measured from there; or the person wears high heels. */
    FEET_RAISED,
    /** The top of the head has no depth. The interval of the stature extends upwards. */
    HEAD_UNSEEN,
    /** The person cannot be separated from a wall or shelf: step away from it. */
    STEP_TO_THE_MIDDLE,
    /** A part of the body has no depth: dark or shiny clothes. */
    DEPTH_MISSING;

    /** The text to show or speak to the person, at most six words: "Step back". [language]: "en", "de", "es", "fr" or "zh". */
    @JvmOverloads
    fun text(language: String = "en"): String =
        requireNotNull(Native.text(Native.guidanceText(ordinal, language.toByteArray()))) { "no language '$language'" }
}

/** Why no person is found in a frame. Order of IM2FIT_DIAGNOSIS_... */
enum class DiagnosisCode {
    NONE, LITTLE_DEPTH, RAW_DISPARITY, BYTES_SWAPPED, PLAYER_BITS, CONFIDENCE_BITS, FLOAT_VALUES, NO_DEPTH_PICTURE, UNIT,
    ROTATED, CENTRE, FIELD_OF_VIEW,
    /** A code of a newer library: [Diagnosis.text] describes it. */
    UNKNOWN;

    internal companion object {
        fun of(code: Int) = values().getOrElse(code) { UNKNOWN }
    }
}

/**
 * The reason why no person is found in a frame.
 *
 * @property text likely cause and remedy in English, as printed by the programs; "" for NONE
 * @property unitMm for UNIT and PLAYER_BITS: millimetres per unit; 0: not known
 * @property rotateDeg for ROTATED: the rotation that makes the picture upright
 */
data class Diagnosis(val code: DiagnosisCode, val text: String, val unitMm: Float, val rotateDeg: Int)

/**
 * The mask of the person in a frame, to draw over the picture.
 *
 * @property pixels rows from the top of the upright picture, [width] bytes each: -1 (255) the person, 0 everything else
 * @property userId the person, as [Progress.userId]; 0: no person is in view, and the mask is empty
 * @property sequence of the frame, as pushed; [timeNs] too
 */
class Mask(
    val width: Int, val height: Int, val pixels: ByteArray, val userId: Int, val sequence: Long, val timeNs: Long
) {
    /** Whether the person is at a place of the upright picture. */
    operator fun get(x: Int, y: Int): Boolean = pixels[y * width + x] != 0.toByte()
}

/** The views used for a measurement. Order of IM2FIT_VIEWS_... */
enum class Views {
    /** Nobody was measured. */
    NONE, FRONT, FRONT_AND_BACK,
    /** The front and a turn of at least 150 degrees. */
    AROUND
}

/** The person's own arms. */
enum class Arm { LEFT, RIGHT }

/** HE NE TO LS RS LE RE LA RA LH RH LK RK LF RF: LA and RA are the hands, LH and RH the hips. */
enum class JointName { HE, NE, TO, LS, RS, LE, RE, LA, RA, LH, RH, LK, RK, LF, RF }

/**
 * Millimetres in the camera's axes of the upright picture: x right, y down, z forward.
 *
 * @property confidence 0..1: probability that the error is below 50 mm. Below 0.25: not visible, inferred
 */
data class Joint(val name: JointName, val x: Float, val y: Float, val z: Float, val confidence: Float)

/**
 * The session after the latest frame that was processed.
 *
 * @property guidance of the latest frame
 * @property armsClose the arms to which [Guidance.ARMS_CLOSE] refers
 * @property joints to draw, smoothed; empty without a person
 * @property turnedDeg [Turn.AROUND], from TURNING on: the largest angle that the person has turned, degrees; positive to the
 *   person's left
 * @property framesWanted for a progress bar: show [framesUsed] out of it; with [Turn.BACK] it applies to each side
 * @property userId the person of joints and guidance, from 1; 0: no person is in view
 * @property session counts the sessions begun after [FitSession.next], from 0
 */
data class Progress(
    val state: State, val guidance: Set<Guidance>, val armsClose: Set<Arm>, val framesSeen: Long, val framesUsed: Long,
    val framesDropped: Long, val userId: Int, val session: Int, val joints: List<Joint>,
    val turnedDeg: Float, val framesWanted: Long
) {
    /** Whether anything that is displayed to the person has changed. */
    fun saysMoreThan(before: Progress?): Boolean = before == null || state != before.state ||
        guidance != before.guidance || armsClose != before.armsClose || framesUsed != before.framesUsed ||
        turnedDeg != before.turnedDeg
}

internal inline fun <reified T : Enum<T>> bitsOf(bits: Long): Set<T> =
    enumValues<T>().filterTo(LinkedHashSet()) { bits shr it.ordinal and 1L == 1L }
