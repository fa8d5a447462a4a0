{{- define "ccdt.name" -}}
{{- if contains .Chart.Name .Release.Name }}{{ .Release.Name }}{{ else }}{{ .Release.Name }}-{{ .Chart.Name }}{{ end }}
{{- end }}

{{/* What pods are found by; never changes. */}}
{{- define "ccdt.selector" -}}
app.kubernetes.io/name: {{ .Chart.Name }}
app.kubernetes.io/instance: {{ .Release.Name }}
{{- end }}

{{- define "ccdt.labels" -}}
{{ include "ccdt.selector" . }}
app.kubernetes.io/version: {{ .Chart.AppVersion | quote }}
app.kubernetes.io/managed-by: {{ .Release.Service }}
helm.sh/chart: {{ .Chart.Name }}-{{ .Chart.Version }}
{{- end }}

{{/* The kind of what makes pods. */}}
{{- define "ccdt.workload" -}}
{{- if eq .Values.store.kind "disk" }}StatefulSet{{ else }}Deployment{{ end }}
{{- end }}

{{/* A value of any kind as text. Whole numbers are read as others, of which large ones would have an exponent. */}}
{{- define "ccdt.text" -}}
{{- if not (kindIs "float64" .) }}{{ . }}
{{- else if eq . (floor .) }}{{ int64 . }}
{{- else }}{{ . }}
{{- end }}
{{- end }}

{{- define "ccdt.redisSecret" -}}
{{- .Values.store.redis.existingSecret | default (printf "%s-redis" (include "ccdt.name" .)) }}
{{- end }}

{{/* The Secret with API keys; nothing if there are none. */}}
{{- define "ccdt.keysSecret" -}}
{{- if .Values.keys.existingSecret }}{{ .Values.keys.existingSecret }}
{{- else if .Values.keys.list }}{{ include "ccdt.name" . }}-keys
{{- end }}
{{- end }}
