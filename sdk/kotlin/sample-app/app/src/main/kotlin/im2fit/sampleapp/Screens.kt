// SPDX-License-Identifier: Apache-2.0
// What the person sees at each step. All words are in res/values*/strings.xml but those of the guidance and of the tape,
// which the library has.
package im2fit.sampleapp

import android.graphics.Bitmap
import androidx.compose.foundation.Canvas
import androidx.compose.foundation.Image
import androidx.compose.foundation.layout.Arrangement
import androidx.compose.foundation.layout.Box
import androidx.compose.foundation.layout.Column
import androidx.compose.foundation.layout.fillMaxSize
import androidx.compose.foundation.layout.fillMaxWidth
import androidx.compose.foundation.layout.padding
import androidx.compose.foundation.layout.safeDrawingPadding
import androidx.compose.foundation.rememberScrollState
import androidx.compose.foundation.verticalScroll
import androidx.compose.material3.Button
import androidx.compose.material3.LinearProgressIndicator
import androidx.compose.material3.MaterialTheme
import androidx.compose.material3.OutlinedButton
import androidx.compose.material3.Surface
import androidx.compose.material3.Text
import androidx.compose.runtime.Composable
import androidx.compose.ui.Alignment
import androidx.compose.ui.Modifier
import androidx.compose.ui.geometry.Offset
import androidx.compose.ui.geometry.Size
import androidx.compose.ui.graphics.Color
import androidx.compose.ui.graphics.asImageBitmap
import androidx.compose.ui.graphics.drawscope.Stroke
import androidx.compose.ui.res.stringResource
import androidx.compose.ui.unit.dp
import im2fit.sdk.Mask
import im2fit.sdk.Measurement
import im2fit.sdk.Person
import im2fit.sdk.Progress
import im2fit.sdk.State
import im2fit.sdk.tapeDefinitions
import kotlin.math.abs
import kotlin.math.roundToInt

/** What the buttons do. */
class Actions(
    val ask: () -> Unit, val start: (turn: Boolean) -> Unit, val stop: () -> Unit, val delete: () -> Unit
)

/** @param language of the texts that the library has: "en", "de", "es", "fr" or "zh" */
@Composable
fun SampleApp(shown: Shown, language: String, actions: Actions) {
    MaterialTheme {
        Surface(modifier = Modifier.fillMaxSize()) {
            when (shown.step) {
                Step.MEASURING -> MeasuringScreen(shown.progress, shown.mask, language, actions)
                Step.RESULT -> ResultScreen(shown.person!!, language, actions)
                else -> WordsScreen(shown, language, actions)
            }
        }
    }
}

@Composable
fun WordsScreen(shown: Shown, language: String, actions: Actions) {
    Column(
        modifier = Modifier.fillMaxSize().safeDrawingPadding().padding(24.dp).verticalScroll(rememberScrollState()),
        verticalArrangement = Arrangement.spacedBy(16.dp)
    ) {
        Text(stringResource(R.string.app_name), style = MaterialTheme.typography.headlineMedium)
        when (shown.step) {
            Step.UNSUPPORTED -> Text(stringResource(R.string.unsupported))
            Step.PERMISSION -> {
                Text(stringResource(R.string.permission))
                Button(onClick = actions.ask) { Text(stringResource(R.string.ask_permission)) }
            }
            Step.NOT_MEASURED -> {
                Text(stringResource(R.string.not_measured))
                for (code in shown.guidance) Text(code.text(language))
            }
            Step.FAILED -> Text(stringResource(R.string.failed, shown.failure.orEmpty()))
            else -> Text(stringResource(R.string.privacy))
        }
        if (shown.step == Step.READY || shown.step == Step.NOT_MEASURED || shown.step == Step.FAILED) {
            Text(stringResource(R.string.how_to_stand))
            Button(onClick = { actions.start(true) }) { Text(stringResource(R.string.start_turn)) }
            OutlinedButton(onClick = { actions.start(false) }) { Text(stringResource(R.string.start_front)) }
        }
    }
}

/** The person's outline, the most urgent request, and how far it is. */
@Composable
fun MeasuringScreen(progress: Progress?, mask: Mask?, language: String, actions: Actions) {
    Box(modifier = Modifier.fillMaxSize(), contentAlignment = Alignment.Center) {
        if (mask != null) {
            Image(picture(mask).asImageBitmap(), contentDescription = null, modifier = Modifier.fillMaxSize())
        }
        if (progress != null && progress.state == State.TURNING) TurnRing(progress.turnedDeg)
        Column(
            modifier = Modifier.fillMaxSize().safeDrawingPadding().padding(24.dp), verticalArrangement = Arrangement.SpaceBetween,
            horizontalAlignment = Alignment.CenterHorizontally
        ) {
            Text(request(progress, language), style = MaterialTheme.typography.headlineMedium)
            Column(modifier = Modifier.fillMaxWidth(), verticalArrangement = Arrangement.spacedBy(16.dp)) {
                LinearProgressIndicator(progress = { share(progress) }, modifier = Modifier.fillMaxWidth())
                OutlinedButton(onClick = actions.stop) { Text(stringResource(R.string.stop)) }
            }
        }
    }
}

/** A ring that fills as the person turns. */
@Composable
fun TurnRing(turnedDeg: Float) {
    Canvas(modifier = Modifier.fillMaxSize().padding(48.dp)) {
        val side = minOf(size.width, size.height)
        val corner = Offset((size.width - side) / 2, (size.height - side) / 2)
        val stroke = Stroke(width = side / 24)
        drawArc(Color.DarkGray, -90f, 360f, false, topLeft = corner, size = Size(side, side), style = stroke)
        // A turn to the person's left, which is positive, fills it clockwise; one to the right the other way.
        drawArc(
            Color.Green, -90f, turnedDeg.coerceIn(-360f, 360f), false, topLeft = corner, size = Size(side, side),
            style = stroke
        )
    }
}

@Composable
fun ResultScreen(person: Person, language: String, actions: Actions) {
    val names = tapeDefinitions(language).associate { it.id to it.name }
    Column(
        modifier = Modifier.fillMaxSize().safeDrawingPadding().padding(24.dp).verticalScroll(rememberScrollState()),
        verticalArrangement = Arrangement.spacedBy(8.dp)
    ) {
        Text(stringResource(R.string.size, person.size.best), style = MaterialTheme.typography.headlineMedium)
        for ((measurement, value) in person.measurements) {
            Text(
                stringResource(
                    R.string.value, names[measurement.id] ?: measurement.id, shownNumber(measurement, value.value),
                    shownNumber(measurement, value.low), shownNumber(measurement, value.high), shownUnit(measurement)
                )
            )
        }
        Text(stringResource(R.string.interval))
        Button(onClick = actions.delete) { Text(stringResource(R.string.delete)) }
    }
}

/** The first thing the person should do; nothing to do: that it measures. */
@Composable
fun request(progress: Progress?, language: String): String {
    val first = progress?.guidance?.firstOrNull()
    return if (first != null) first.text(language) else stringResource(R.string.hold_still)
}

/** From 0 to 1; of a turn, half of one is enough. */
fun share(progress: Progress?): Float = when {
    progress == null -> 0f
    progress.state == State.TURNING -> (abs(progress.turnedDeg) / 360f).coerceIn(0f, 1f)
    progress.framesWanted == 0L -> 0f
    else -> (progress.framesUsed.toFloat() / progress.framesWanted).coerceIn(0f, 1f)
}

/** Lengths in cm. */
fun shownNumber(measurement: Measurement, value: Float): String =
    if (measurement.unit == "mm") (value / 10).roundToInt().toString() else value.roundToInt().toString()

fun shownUnit(measurement: Measurement): String = if (measurement.unit == "mm") "cm" else measurement.unit

/** The person as a light shape; all else is dark. */
fun picture(mask: Mask): Bitmap = Bitmap.createBitmap(colours(mask), mask.width, mask.height, Bitmap.Config.ARGB_8888)

fun colours(mask: Mask): IntArray = IntArray(mask.width * mask.height) { i -> if (mask.pixels[i] != 0.toByte()) LIGHT else DARK }

private const val LIGHT = 0xFFB0D8FF.toInt()
private const val DARK = 0xFF101418.toInt()
